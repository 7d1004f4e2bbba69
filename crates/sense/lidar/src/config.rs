//! Settings of the odometry, each with the reason for its value.

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::error::LidarError;
use crate::propagate::ImuNoise;

/// Settings. [`Config::default`] is for a Mid-360 that is looked at by itself, [`Config::g1`] for the one on a G1.
#[derive(Clone, Debug, PartialEq)]
pub struct Config {
    /// Pose of the LiDAR in the IMU frame. Mid-360: the IMU sits at (11, 23.29, -44.12) mm in the LiDAR frame (manual).
    pub imu_from_lidar: Isometry3<f64>,
    /// Pose of the LiDAR in the frame of the body whose pose is wanted: the torso, or identity for the LiDAR itself.
    pub body_from_lidar: Isometry3<f64>,
    /// Correct the pose of the LiDAR against the IMU. Off: it is fixed in one housing, and a walk hardly shows it.
    pub estimate_extrinsic: bool,
    /// Noise of the IMU. Accelerometer and biases as published for a Mid-360; of the gyroscope a hundredth: a walk on bare ground is
    /// then held by it (measured). Resting Mid-360s show 6e-6 to 3e-4, the latter a tone of 77 Hz that needs no notch: the mean of two
    /// samples has a third of it, and its integral stays small.
    pub imu_noise: ImuNoise,
    /// Largest acceleration that the IMU can show `[m/s^2]`. Mid-360: 4 g. A sample there means only "more".
    pub accel_range: f64,
    /// Variance of an axis of a sample at the end of its range `[m^2/s^4]`: an impact of 60 m/s^2 is 20 more than 4 g.
    pub saturated_variance: f64,
    /// Variance of a point's distance from its plane `[m^2]`: noise of range, of the map and of the plane.
    pub plane_variance: f64,
    /// Linearizations of an update. Three are what FAST-LIO2 takes for a Mid-360.
    pub iterations: usize,
    /// Nearest range that counts `[m]`: nearer is the robot itself.
    pub blind_m: f64,
    /// Farthest range that counts `[m]`.
    pub range_m: f64,
    /// Edge of the cubes that a scan is thinned to `[m]`. Published: 0.5 m. Less keeps more of a goal's net.
    pub scan_voxel_m: f64,
    /// Edge of the cubes of the map `[m]`. Published: 0.5 m, at which goals on a pitch give 8 cm instead of 3.
    pub map_voxel_m: f64,
    /// Half of the width of the box that the map covers `[m]`.
    pub map_half_width_m: f64,
    /// Most points in the map: 30 MB. One minute on a pitch leaves 30 000.
    pub map_capacity: usize,
    /// The fifth neighbor of a point is at most this far `[m]`.
    pub neighbor_m: f64,
    /// No point of a plane is farther from it `[m]`. Published: 0.1 m; half of it keeps planes through the corner of a net out.
    pub plane_thickness_m: f64,
    /// A match with distance d at range r counts if `1 - 0.9 |d| / sqrt(r)` is above this.
    pub match_score: f64,
    /// Standing still before the start `[s]`.
    pub standstill_s: f64,
    /// Fewest points of a thinned scan: below it the sensor is covered.
    pub min_points: usize,
    /// Tracking is lost if the share of matched points, of all or of those off the ground, falls below this part of the usual share.
    pub lost_share: f64,
    /// While lost, a scan is taken for the way back if the share of matched points is at least this part of the usual share.
    pub recovery_share: f64,
    /// Tracking is lost if a scan moves the prediction of 0.1 s by more `[m]`.
    pub jump_m: f64,
    /// Tracking is lost if a scan turns the prediction of 0.1 s by more `[rad]`.
    pub jump_rad: f64,
    /// While lost, a scan is taken for the way back if it moves the prediction by at most this `[m]`.
    pub recovery_m: f64,
    /// While lost, a scan is taken for the way back if it turns the prediction by at most this `[rad]`.
    pub recovery_rad: f64,
    /// Good scans in a row that end the loss.
    pub recovery_scans: u32,
    /// A loss that lasts longer `[s]` does not end by itself: the IMU alone is then more than a meter off.
    pub give_up_s: f64,
    /// Delay of data, against the shortest seen, that counts as late `[s]`.
    pub late_s: f64,
    /// Distance of IMU samples that counts as a gap `[s]`: ten samples.
    pub imu_gap_s: f64,
    /// Silence of the LiDAR that counts as loss `[s]`.
    pub silence_s: f64,
    /// A direction is unobservable if fewer planes (sum of squared cosines) face it in the mean of the last scans. A pitch has four or more,
    /// a bare corridor 0.3.
    pub facing_planes: f64,
    /// Speed along an unobservable direction that is taken for usual `[m/s]`: it keeps the IMU alone from running away.
    pub usual_speed: f64,
}

impl Default for Config {
    fn default() -> Self {
        Self {
            imu_from_lidar: Isometry3::from_parts(
                Translation3::new(-0.011, -0.023_29, 0.044_12),
                UnitQuaternion::identity(),
            ),
            body_from_lidar: Isometry3::identity(),
            estimate_extrinsic: false,
            imu_noise: ImuNoise { gyro: 1e-3, accel: 0.1, gyro_bias: 1e-4, accel_bias: 1e-4 },
            accel_range: 4.0 * 9.81,
            saturated_variance: 400.0,
            plane_variance: 0.001,
            iterations: 3,
            blind_m: 0.5,
            range_m: 100.0,
            scan_voxel_m: 0.4,
            map_voxel_m: 0.3,
            map_half_width_m: 100.0,
            map_capacity: 400_000,
            neighbor_m: 5.0_f64.sqrt(),
            plane_thickness_m: 0.05,
            match_score: 0.9,
            standstill_s: 0.5,
            min_points: 50,
            lost_share: 0.5,
            recovery_share: 0.8,
            jump_m: 0.3,
            jump_rad: 0.15,
            recovery_m: 1.0,
            recovery_rad: 0.3,
            recovery_scans: 3,
            give_up_s: 5.0,
            late_s: 0.06,
            imu_gap_s: 0.05,
            silence_s: 0.25,
            facing_planes: 1.5,
            usual_speed: 1.0,
        }
    }
}

impl Config {
    /// The Mid-360 in the head of a Unitree G1, upside down; poses are those of `torso_link`.
    #[must_use]
    pub fn g1() -> Self {
        Self { body_from_lidar: g1_torso_from_lidar(), ..Self::default() }
    }

    /// Checks every setting.
    ///
    /// # Errors
    ///
    /// Names the first setting that makes no sense.
    pub fn check(&self) -> Result<(), LidarError> {
        let positive = [
            ("accel_range", self.accel_range),
            ("imu_noise.gyro", self.imu_noise.gyro),
            ("imu_noise.accel", self.imu_noise.accel),
            ("imu_noise.gyro_bias", self.imu_noise.gyro_bias),
            ("imu_noise.accel_bias", self.imu_noise.accel_bias),
            ("saturated_variance", self.saturated_variance),
            ("plane_variance", self.plane_variance),
            ("range_m", self.range_m),
            ("scan_voxel_m", self.scan_voxel_m),
            ("map_voxel_m", self.map_voxel_m),
            ("map_half_width_m", self.map_half_width_m),
            ("neighbor_m", self.neighbor_m),
            ("plane_thickness_m", self.plane_thickness_m),
            ("standstill_s", self.standstill_s),
            ("jump_m", self.jump_m),
            ("jump_rad", self.jump_rad),
            ("recovery_m", self.recovery_m),
            ("recovery_rad", self.recovery_rad),
            ("give_up_s", self.give_up_s),
            ("late_s", self.late_s),
            ("imu_gap_s", self.imu_gap_s),
            ("silence_s", self.silence_s),
            ("usual_speed", self.usual_speed),
        ];
        for (name, value) in positive {
            if !(value.is_finite() && value > 0.0) {
                return Err(setting(name, "a number above 0", &value));
            }
        }
        for (name, value) in [
            ("match_score", self.match_score),
            ("lost_share", self.lost_share),
            ("recovery_share", self.recovery_share),
        ] {
            if !(0.0..1.0).contains(&value) {
                return Err(setting(name, "a number from 0 to below 1", &value));
            }
        }
        if !(self.blind_m.is_finite() && self.blind_m >= 0.0 && self.blind_m < self.range_m) {
            return Err(setting("blind_m", "a number from 0 to below range_m", &self.blind_m));
        }
        if self.map_capacity < 1000 {
            return Err(setting("map_capacity", "at least 1000", &self.map_capacity));
        }
        if self.iterations == 0 {
            return Err(setting("iterations", "at least 1", &self.iterations));
        }
        Ok(())
    }
}

fn setting(name: &'static str, expected: &'static str, found: &dyn core::fmt::Display) -> LidarError {
    LidarError::Setting { name, expected, found: found.to_string() }
}

/// Pose of the Mid-360 in a G1's `torso_link`: turned about x by half a turn, then pitched by 2.3 degrees.
#[must_use]
pub fn g1_torso_from_lidar() -> Isometry3<f64> {
    let tilt = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), 2.3_f64.to_radians());
    let upside_down = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), core::f64::consts::PI);
    Isometry3::from_parts(Translation3::new(0.000_283_5, 0.000_03, 0.416_18), tilt * upside_down)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_defaults_pass_and_a_wrong_setting_is_named() {
        assert!(Config::default().check().is_ok());
        let error = Config { scan_voxel_m: 0.0, ..Config::default() }.check().expect_err("no cubes of 0 m");
        assert_eq!(error.to_string(), "scan_voxel_m: expected a number above 0, found 0");
        let error = Config { lost_share: f64::NAN, ..Config::default() }.check().expect_err("not a number");
        assert!(error.to_string().starts_with("lost_share:"), "{error}");
    }

    #[test]
    fn on_a_g1_up_in_the_lidar_frame_is_down_in_the_torso() {
        let up = g1_torso_from_lidar().rotation * Vector3::z();
        assert!((up.z + 2.3_f64.to_radians().cos()).abs() < 1e-12, "{up}");
        let ahead = g1_torso_from_lidar().rotation * Vector3::x();
        assert!(ahead.x > 0.99, "{ahead}");
    }
}
