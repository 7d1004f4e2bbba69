//! What the policy sees wrongly of ball and goal, as typed values.

use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::{Range, check_ranges, value_error};

/// Errors of ball and goal perception in the policy's copy of the observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerceptionPreset {
    /// True: outside a distance band, drawn for each episode, the last seen ball position (base frame) is held.
    pub blind_zone: bool,
    /// Range of the band's near end [m].
    pub near_m: Range,
    /// Range of the band's far end [m].
    pub far_m: Range,
    /// True: Gaussian noise with deviation `c_min + |v| / c_vel + distance / c_dist` on ball and goal (paper, section on
    /// physics-guided randomization).
    pub gaussian: bool,
    /// Constant part [m].
    pub c_min: f64,
    /// Divisor of the object's speed relative to the base [1/s].
    pub c_vel: f64,
    /// Divisor of the object's distance.
    pub c_dist: f64,
    /// Deviation of the Gaussian noise on each horizontal component of the ball's velocity, with `gaussian`; it matters where the policy
    /// sees the ball ahead of time ([`crate::ObservationPreset::lead_ball`]) [m/s].
    #[serde(default = "centimeters_per_second")]
    pub ball_velocity_m_s: f64,
    /// Age of what is seen [s], drawn for each episode and rounded to control steps: a position of then, in the base frame
    /// of then.
    #[serde(default)]
    pub latency_s: Range,
    /// Time between two pictures [s], the first at a random phase; up to the control period: a picture every control step.
    #[serde(default)]
    pub frame_s: f64,
    /// Probability that an object is not found in a picture; the last position is held.
    #[serde(default)]
    pub dropout: f64,
    /// True: the ball is seen only inside the picture of the head camera.
    #[serde(default)]
    pub visible_band: bool,
    /// The head camera.
    #[serde(default)]
    pub camera: CameraPreset,
    /// True: all of this holds in evaluations too, which are undisturbed otherwise.
    #[serde(default)]
    pub in_evaluation: bool,
}

/// The head camera, fixed to the anchor body (torso).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPreset {
    /// Place in the anchor's frame [m].
    pub mount_m: [f64; 3],
    /// Angle of the optical axis below the anchor's x axis [degrees].
    pub down_deg: f64,
    /// Full angle of the picture across [degrees].
    pub across_deg: f64,
    /// Full angle of the picture from top to bottom [degrees].
    pub upright_deg: f64,
}

impl Default for CameraPreset {
    /// The Unitree G1's depth camera, 1.27 m above the ground on straight legs (the torso's frame is then 0.84 m up).
    fn default() -> Self {
        Self { mount_m: [0.058, 0.018, 0.43], down_deg: 47.6, across_deg: 87.0, upright_deg: 58.0 }
    }
}

impl CameraPreset {
    /// True if a point in the anchor's frame [m] is inside the picture.
    pub fn sees(&self, point: [f64; 3]) -> bool {
        let [x, y, z] = [0, 1, 2].map(|k| point[k] - self.mount_m[k]);
        let (s, c) = self.down_deg.to_radians().sin_cos();
        let (depth, up) = (c * x - s * z, s * x + c * z);
        let half = |degrees: f64| (0.5 * degrees.to_radians()).tan();
        depth > 0.0 && y.abs() <= depth * half(self.across_deg) && up.abs() <= depth * half(self.upright_deg)
    }
}

fn centimeters_per_second() -> f64 {
    0.03
}

impl PerceptionPreset {
    /// True if ball and goal come from pictures: late, seldom, or not always; else they are seen anew at every observation.
    pub(crate) fn pictures(&self) -> bool {
        self.latency_s[1] > 0.0 || self.frame_s > 0.0 || self.dropout > 0.0 || self.visible_band
    }

    /// True if anything differs from the truth.
    pub(crate) fn errs(&self) -> bool {
        self.blind_zone || self.gaussian || self.pictures()
    }

    pub(crate) fn check(&self) -> Result<(), TaskError> {
        let key = |name: &str| format!("observations.perception.{name}");
        check_ranges(&[(&key("near_m"), self.near_m), (&key("far_m"), self.far_m)])?;
        check_ranges(&[(&key("latency_s"), self.latency_s)])?;
        for (name, value, limits, expected) in [
            ("c_vel", self.c_vel, [f64::MIN_POSITIVE, f64::MAX], "a positive number"),
            ("c_dist", self.c_dist, [f64::MIN_POSITIVE, f64::MAX], "a positive number"),
            ("ball_velocity_m_s", self.ball_velocity_m_s, [0.0, f64::MAX], "zero or more"),
            ("latency_s.0", self.latency_s[0], [0.0, 1.0], "0 to 1 s"),
            ("latency_s.1", self.latency_s[1], [0.0, 1.0], "0 to 1 s"),
            ("frame_s", self.frame_s, [0.0, 1.0], "0 to 1 s"),
            ("dropout", self.dropout, [0.0, 1.0], "a share between 0 and 1"),
            ("camera.across_deg", self.camera.across_deg, [1.0, 179.0], "1 to 179 degrees"),
            ("camera.upright_deg", self.camera.upright_deg, [1.0, 179.0], "1 to 179 degrees"),
            ("camera.down_deg", self.camera.down_deg, [-90.0, 90.0], "-90 to 90 degrees"),
        ] {
            if !(limits[0]..=limits[1]).contains(&value) {
                return Err(value_error(&key(name), expected, value.to_string()));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::TaskPreset;

    #[test]
    fn the_default_noise_is_two_centimeters_near_and_ten_far_and_fast() {
        let preset = TaskPreset::builtin("stage2").expect("valid").observations.perception;
        let sigma = |v, d| crate::perception::deviation::<f64>(v, d, &preset);
        assert!((sigma(0.0, 1.0) - 0.02).abs() < 0.001, "{}", sigma(0.0, 1.0));
        assert!((sigma(1.0, 3.0) - 0.10).abs() < 0.002, "{}", sigma(1.0, 3.0));
    }

    #[test]
    fn the_camera_sees_the_ground_before_the_feet_and_neither_far_nor_aside() {
        let camera = CameraPreset::default();
        // Upright on straight legs the torso's frame is 0.84 m above the ground.
        let ball = |ahead: f64, left: f64| camera.sees([ahead, left, 0.11 - 0.84]);
        assert!((camera.mount_m[2] + 0.84 - 1.27).abs() < 1e-9);
        // The band's edges: 76.6 and 18.6 degrees below the horizontal, 1.16 m above the ball.
        let edges = [76.6_f64, 18.6].map(|deg| camera.mount_m[0] + 1.16 / deg.to_radians().tan());
        assert!(!ball(edges[0] - 0.02, 0.0) && ball(edges[0] + 0.02, 0.0));
        assert!(ball(edges[1] - 0.05, 0.0) && !ball(edges[1] + 0.05, 0.0), "{edges:?}");
        assert!(ball(1.0, 0.8) && !ball(1.0, 1.5) && !ball(-1.0, 0.0));
    }
}
