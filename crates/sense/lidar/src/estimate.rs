//! What users get: a pose with its time, its covariance and the state of the odometry.

use nalgebra::{Isometry3, SMatrix, Vector3};

use crate::health::Health;

/// Pose and motion at the end of a scan.
#[derive(Clone, Debug)]
pub struct Estimate {
    /// When, by the sensor's clock `[s]`.
    pub time_s: f64,
    /// Which odometry frame: a restart begins a new one, and poses of two frames must not be mixed.
    pub frame: u32,
    /// Pose of the body (the torso, or the LiDAR itself) in the odometry frame: z up, origin and heading of the IMU at the start.
    pub odometry_from_body: Isometry3<f64>,
    /// Velocity of the body's origin in the odometry frame `[m/s]`.
    pub velocity: Vector3<f64>,
    /// Angular velocity of the body in its own frame `[rad/s]`.
    pub angular_velocity: Vector3<f64>,
    /// Covariance of the IMU's position `[m]` (odometry frame), rotation `[rad]` (IMU frame) and velocity `[m/s]` (odometry frame).
    pub covariance: SMatrix<f64, 9, 9>,
    /// How far all this can be trusted.
    pub health: Health,
    /// Points of the thinned scan.
    pub points: usize,
    /// Share of them that fit the map.
    pub share: f64,
    /// Share of the points off the ground that fit the map.
    pub off_ground_share: f64,
    /// How far the scan moved the prediction `[m]`.
    pub correction_m: f64,
    /// Set on the scan that ends a loss: how long it lasted `[s]`.
    pub recovered_after_s: Option<f64>,
}

impl Estimate {
    /// Standard deviation of the position along `direction` (unit vector, odometry frame) `[m]`.
    #[must_use]
    pub fn position_deviation(&self, direction: &Vector3<f64>) -> f64 {
        let p = self.covariance.fixed_view::<3, 3>(0, 0);
        (direction.transpose() * p * direction).x.max(0.0).sqrt()
    }
}
