//! What the policy sees wrongly of ball and goal, as typed values.

use paid_track::{CameraPreset, PositionNoise};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::Range;
use crate::preset::numbers::{LENGTH, POSITIVE, SHARE, SPEED, check};

/// Where these values stand in a task.
const TABLE: &str = "observations.perception";

/// Errors of ball and goal perception in the policy's copy of the observation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PerceptionPreset {
    /// True: outside a distance band, drawn for each episode, the last seen ball position is held (`memory_frame`).
    pub blind_zone: bool,
    /// Range of the band's near end `[m]`.
    pub near_m: Range,
    /// Range of the band's far end `[m]`.
    pub far_m: Range,
    /// True: Gaussian noise with deviation `c_min + |v| / c_vel + distance / c_dist` on ball and goal (paper, section on
    /// physics-guided randomization).
    pub gaussian: bool,
    /// Constant part `[m]`.
    pub c_min: f64,
    /// Divisor of the object's speed relative to the base `[1/s]`.
    pub c_vel: f64,
    /// Divisor of the object's distance.
    pub c_dist: f64,
    /// Deviation of the Gaussian noise on each horizontal component of the ball's velocity, with `gaussian` `[m/s]`. It matters where
    /// the policy observes `ball_at_strike`.
    pub ball_velocity_m_s: f64,
    /// Age of what is seen `[s]`, drawn for each episode and rounded to control steps: a position at capture time, in the
    /// `memory_frame`.
    pub latency_s: Range,
    /// Time between two pictures `[s]`, the first at a random phase; up to the control period: a picture every control step.
    pub frame_s: f64,
    /// Probability that an object is not found in a picture; the last position is held.
    pub dropout: f64,
    /// True: the ball is seen only inside the picture of the head camera.
    pub visible_band: bool,
    /// The head camera, on the anchor body (torso).
    pub camera: CameraPreset,
    /// True: all of this holds in evaluations too, which are undisturbed otherwise.
    pub in_evaluation: bool,
    /// The frame in which a position is remembered while the object is out of sight or its picture is on the way.
    pub memory_frame: MemoryFrame,
}

/// The frame in which seen positions are remembered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MemoryFrame {
    /// The base frame at capture time: what is remembered moves with the robot. The paper's memory is in the world frame instead.
    Base,
    /// The world frame, as perfect odometry gives it: what is remembered stays where it was seen.
    World,
}

impl PerceptionPreset {
    /// Noise of seen positions, where `gaussian` is on.
    pub fn noise(&self) -> PositionNoise {
        PositionNoise { c_min: self.c_min, c_vel: self.c_vel, c_dist: self.c_dist }
    }

    /// True if ball and goal come from a camera: delayed, seldom, or not always; else they are seen anew at every observation.
    pub(crate) fn has_camera(&self) -> bool {
        self.latency_s[1] > 0.0 || self.frame_s > 0.0 || self.dropout > 0.0 || self.visible_band
    }

    /// Ball and goal are seen as they are.
    pub(crate) fn switch_off(&mut self) {
        (self.blind_zone, self.gaussian, self.visible_band, self.in_evaluation) =
            (false, false, false, false);
        (self.latency_s, self.frame_s, self.dropout) = ([0.0; 2], 0.0, 0.0);
    }

    /// True if anything differs from the truth.
    pub(crate) fn errs(&self) -> bool {
        self.blind_zone || self.gaussian || self.has_camera()
    }

    pub(crate) fn check(&self) -> Result<(), TaskError> {
        let second = ([0.0, 1.0], "0 to 1 s");
        check(
            TABLE,
            &[
                ("near_m", self.near_m.into(), LENGTH),
                ("far_m", self.far_m.into(), LENGTH),
                ("c_min", self.c_min.into(), LENGTH),
                ("c_vel", self.c_vel.into(), POSITIVE),
                ("c_dist", self.c_dist.into(), POSITIVE),
                ("ball_velocity_m_s", self.ball_velocity_m_s.into(), SPEED),
                ("latency_s", self.latency_s.into(), second),
                ("frame_s", self.frame_s.into(), second),
                ("dropout", self.dropout.into(), SHARE),
            ],
        )?;
        self.camera.check().map_err(|error| TaskError::below(&format!("{TABLE}.camera"), error))
    }
}

#[cfg(test)]
mod tests {

    use crate::TaskPreset;

    #[test]
    fn the_default_noise_is_two_centimeters_near_and_ten_far_and_fast() {
        let preset = TaskPreset::builtin("paper_stage2").expect("valid").observations.perception;
        let sigma = |v: f64, d| preset.noise().deviation(v, d);
        assert!((sigma(0.0, 1.0) - 0.02).abs() < 0.001, "{}", sigma(0.0, 1.0));
        assert!((sigma(1.0, 3.0) - 0.10).abs() < 0.002, "{}", sigma(1.0, 3.0));
    }
}
