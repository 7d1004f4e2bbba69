//! One sweep of the LiDAR.

use nalgebra::Vector3;

/// One return, in the LiDAR frame of the moment at which it was measured.
/// A ray that did not come back is the origin, as a Mid-360 sends it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Time since the begin of the scan `[s]`.
    pub offset_s: f64,
    /// Position `[m]`.
    pub position: Vector3<f64>,
}

/// The returns of a short time, 0.1 s on a Mid-360.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scan {
    /// Begin, by the sensor's clock `[s]`.
    pub start_s: f64,
    /// End, by the sensor's clock `[s]`.
    pub end_s: f64,
    /// The returns, with or without the rays that did not come back.
    pub points: Vec<Point>,
}
