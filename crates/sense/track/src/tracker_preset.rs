//! Constants of the ball tracker.

use serde::{Deserialize, Serialize};

use crate::ValueError;
use crate::error::{range_within, within};

/// What the tracker expects of a ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct TrackerPreset {
    /// Standard deviation of the velocity of a ball that was never seen before, on each axis `[m/s]`. Default 0.2: balls roll at 0.1
    /// to 0.4 m/s.
    pub speed_m_s: f64,
    /// How many times as likely a new ball rests as it rolls. Default 1: nothing is known.
    pub rest_odds: f64,
    /// Process noise of a rolling ball, the square root of the acceleration's spectral density `[m/s^1.5]`: its velocity wanders by
    /// this in a second. Default 0.02: uneven ground, and a decay that is not quite the identified one.
    pub rolling_noise: f64,
    /// The same for a ball at rest. Default 0.005: it becomes steady, and a slow ball that was taken for one at rest is found out.
    pub resting_noise: f64,
    /// The same around the strike. Default 8: within 0.25 s any velocity up to 4 m/s.
    pub strike_noise: f64,
    /// Where that holds, from and to this long after the strike of the reference `[s]`. Default -0.1 to 0.3: policies strike a tenth of a
    /// second early or late, and two images later the new velocity is known.
    pub strike_window_s: [f64; 2],
    /// Mahalanobis distance (standard deviations) beyond which an image is not the ball. Default 4: a good image is refused once in
    /// 3000, with twice the noise once in 7.
    pub gate: f64,
    /// This many refused images in a row that fit each other are the ball after all. Default 3: false detections are scattered.
    pub reacquire: usize,
    /// Two images are not of one ball if it had to be faster `[m/s]`; the covariance of the velocity grows no further. Default 8: twice
    /// the fastest kick.
    pub fastest_m_s: f64,
}

impl Default for TrackerPreset {
    fn default() -> Self {
        Self {
            speed_m_s: 0.2,
            rest_odds: 1.0,
            rolling_noise: 0.02,
            resting_noise: 0.005,
            strike_noise: 8.0,
            strike_window_s: [-0.1, 0.3],
            gate: 4.0,
            reacquire: 3,
            fastest_m_s: 8.0,
        }
    }
}

impl TrackerPreset {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is out of range; a filter needs noise in all its parts, or it stops to listen.
    pub fn check(&self) -> Result<(), ValueError> {
        const POSITIVE: [f64; 2] = [1e-6, 1e3];
        for (key, value) in [
            ("speed_m_s", self.speed_m_s),
            ("rest_odds", self.rest_odds),
            ("rolling_noise", self.rolling_noise),
            ("resting_noise", self.resting_noise),
            ("strike_noise", self.strike_noise),
            ("gate", self.gate),
            ("fastest_m_s", self.fastest_m_s),
        ] {
            within(key, value, POSITIVE, "a positive number")?;
        }
        range_within("strike_window_s", self.strike_window_s, [-10.0, 10.0], "within 10 s")?;
        if self.reacquire < 2 {
            return Err(ValueError::new("reacquire", "at least 2 images", self.reacquire));
        }
        Ok(())
    }
}
