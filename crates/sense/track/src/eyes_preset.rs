//! What the simulated eyes of a robot are like.

use paid_lanes::rng::Rng;
use paid_lanes::{Mask, Real, Vec3};
use serde::{Deserialize, Serialize};

use crate::error::{range_within, within};
use crate::{BodyPose, CameraPreset, OdometryPreset, PositionNoise, TrackerPreset, ValueError};

/// Camera, odometry and tracker. Ranges are drawn from for each episode; equal ends give a constant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EyesPreset {
    /// The camera, on the torso. Default: the G1's color image.
    pub camera: CameraPreset,
    /// Images a second. Default 30.
    pub rate_hz: [f64; 2],
    /// Age of an image when it arrives `[s]`, in whole control steps; the robot knows it. Default 0.06: exposure, transfer, detection.
    pub latency_s: [f64; 2],
    /// Nearest and farthest ball from the camera that is found `[m]`. Default 0.2 to 6.
    pub range_m: [f64; 2],
    /// Share of the images of a visible ball in which it is missed. Default 0.05.
    pub dropout: [f64; 2],
    /// Share of the images in which something else is taken for the ball, anywhere in the image. Default 0.01.
    pub false_share: f64,
    /// Constant part of the noise `[m]`, see [`PositionNoise`]. Default 0.01, as for the paper's noise.
    pub c_min: f64,
    /// Divisor of the ball's speed relative to the base `[1/s]`. Default 16.7.
    pub c_vel: f64,
    /// Divisor of its distance. Default 100.
    pub c_dist: f64,
    /// Factor of the noise that the tracker does not know of. Default 1.
    pub noise_scale: [f64; 2],
    /// What the robot takes for the rate at which rolling balls slow down, as a factor of the true one. Default 0.8 to 1.2: as well as an
    /// identification gives it.
    pub decay_scale: [f64; 2],
    /// Images of the ball before the start: the robot stands and looks at it, wherever it lies. Default 20.
    pub first_look: usize,
    /// Errors of odometry.
    pub odometry: OdometryPreset,
    /// The filter.
    pub tracker: TrackerPreset,
}

impl Default for EyesPreset {
    fn default() -> Self {
        Self {
            camera: CameraPreset::color(),
            rate_hz: [30.0; 2],
            latency_s: [0.06; 2],
            range_m: [0.2, 6.0],
            dropout: [0.05; 2],
            false_share: 0.01,
            c_min: 0.01,
            c_vel: 16.7,
            c_dist: 100.0,
            noise_scale: [1.0; 2],
            decay_scale: [0.8, 1.2],
            first_look: 20,
            odometry: OdometryPreset::default(),
            tracker: TrackerPreset::default(),
        }
    }
}

/// What is drawn for an episode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EyesDraw {
    /// Time between two images `[s]`.
    pub period_s: f64,
    /// Age of an image when it arrives `[s]`.
    pub latency_s: f64,
    /// Share of the images without the ball.
    pub dropout: f64,
    /// Factor of the noise.
    pub noise_scale: f64,
    /// Factor of the decay.
    pub decay_scale: f64,
}

impl EyesPreset {
    /// Longest latency `[s]`.
    pub const LATEST_S: f64 = 0.5;

    /// Where a ball at `ball` is in the image of a camera on `carrier`, and neither too near nor too far to be found; both in the world
    /// `[m]`.
    #[inline(always)]
    pub fn in_picture<V: Real>(&self, carrier: &BodyPose<V>, ball: Vec3<V>) -> V::Mask {
        let camera = self.camera.geometry();
        let [near, far] = self.range_m.map(V::c);
        let in_carrier = carrier.rot.tr_mul_vec(ball - carrier.pos);
        let range = (in_carrier - camera.mount()).norm();
        camera.sees(in_carrier).and(range.ge(near)).and(range.le(far))
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValueError> {
        const POSITIVE: [f64; 2] = [f64::MIN_POSITIVE, f64::MAX];
        self.camera.check().map_err(|error| error.below("camera"))?;
        let lower_edge = self.camera.down_deg + 0.5 * self.camera.upright_deg;
        if lower_edge <= 0.0 {
            let expected =
                "an axis so far down that the camera sees the ground: its lower edge below the horizontal";
            let found = format!(
                "{} with a vertical field of view of {} degrees",
                self.camera.down_deg, self.camera.upright_deg
            );
            return Err(ValueError::new("camera.down_deg", expected, found));
        }
        range_within("rate_hz", self.rate_hz, [1.0, 1000.0], "1 to 1000 images a second")?;
        let latest = format!("0 to {} s", Self::LATEST_S);
        range_within("latency_s", self.latency_s, [0.0, Self::LATEST_S], &latest)?;
        range_within("range_m", self.range_m, [0.0, 100.0], "0 to 100 m")?;
        range_within("dropout", self.dropout, [0.0, 1.0], "shares between 0 and 1")?;
        within("false_share", self.false_share, [0.0, 1.0], "a share between 0 and 1")?;
        within("c_min", self.c_min, POSITIVE, "a positive number: a filter needs noise")?;
        within("c_vel", self.c_vel, POSITIVE, "a positive number")?;
        within("c_dist", self.c_dist, POSITIVE, "a positive number")?;
        range_within("noise_scale", self.noise_scale, [0.0, 100.0], "0 to 100")?;
        range_within("decay_scale", self.decay_scale, [0.0, 10.0], "0 to 10")?;
        if !(1..=200).contains(&self.first_look) {
            return Err(ValueError::new("first_look", "1 to 200 images", self.first_look));
        }
        self.odometry.check().map_err(|error| error.below("odometry"))?;
        self.tracker.check().map_err(|error| error.below("tracker"))
    }

    /// Noise of a seen position, as the tracker expects it.
    pub fn noise(&self) -> PositionNoise {
        PositionNoise { c_min: self.c_min, c_vel: self.c_vel, c_dist: self.c_dist }
    }

    /// Draws what an episode has of its own.
    pub fn draw(&self, rng: &mut Rng) -> EyesDraw {
        let mut draw = |[lo, hi]: [f64; 2]| rng.uniform(lo, hi);
        EyesDraw {
            period_s: 1.0 / draw(self.rate_hz),
            latency_s: draw(self.latency_s),
            dropout: draw(self.dropout),
            noise_scale: draw(self.noise_scale),
            decay_scale: draw(self.decay_scale),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn refused(change: impl FnOnce(&mut EyesPreset)) -> String {
        let mut preset = EyesPreset::default();
        change(&mut preset);
        preset.check().expect_err("out of range").to_string()
    }

    #[test]
    fn the_default_is_valid_and_sees_three_quarters_of_a_meter_and_two_meters_ahead() {
        let preset = EyesPreset::default();
        preset.check().expect("valid");
        let sees = |ahead: f64| preset.camera.geometry().sees(Vec3([ahead, 0.0, 0.11 - 0.84]));
        // Edges 68.6 and 26.6 degrees below the horizontal, 1.16 m above the ball: 0.51 and 2.37 m.
        assert!(!sees(0.5) && sees(0.53) && sees(2.35) && !sees(2.4));
    }

    #[test]
    fn values_that_make_no_sense_are_refused_by_key() {
        assert!(refused(|p| p.latency_s = [-0.02, 0.06]).starts_with("latency_s is [-0.02, 0.06], expected"));
        assert!(
            refused(|p| p.camera.down_deg = -30.0)
                .contains("camera.down_deg is -30 with a vertical field of view of 42")
        );
        assert!(refused(|p| p.c_min = 0.0).starts_with("c_min is 0, expected a positive number: a filter"));
        assert!(refused(|p| p.tracker.rolling_noise = 0.0).starts_with("tracker.rolling_noise is 0"));
        assert!(
            refused(|p| p.tracker.reacquire = 1).starts_with("tracker.reacquire is 1, expected at least 2")
        );
        assert!(refused(|p| p.odometry.drift_m_s = [0.02, 0.01]).starts_with("odometry.drift_m_s is"));
        assert!(refused(|p| p.rate_hz = [0.0, 30.0]).contains("images a second"));
        assert!(refused(|p| p.first_look = 0).starts_with("first_look is 0"));
        assert!(refused(|p| p.dropout = [0.0, 1.5]).starts_with("dropout is"));
    }
}
