//! Constants of the memory of balls.

use serde::{Deserialize, Serialize};

use crate::ValueError;
use crate::error::within;

/// When a ball counts as found, as seen and as lost.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct MemoryPreset {
    /// Images that must show a ball at one place before it is confirmed. Default 3: false detections are scattered.
    pub confirm: usize,
    /// A detection multiplies the odds that the ball is there by this. Default 4: a detector that finds four balls in five and a false one
    /// in seven images would allow 5.
    pub found_factor: f64,
    /// An image that should show the ball and does not multiplies them by this. Default 0.6: images in a row miss a ball together.
    pub missed_factor: f64,
    /// They grow no further. Default 100: then ten images in a row without the ball lose it.
    pub most_odds: f64,
    /// Below these odds a ball is lost. Default 0.5.
    pub lost_odds: f64,
    /// A ball whose last image is not older counts as seen `[s]`. Default 0.2: latency and three images.
    pub seen_s: f64,
    /// After this long without an image a ball is lost `[s]`. Default 20.
    pub forget_s: f64,
    /// A ball is lost if its place has this standard deviation `[m]`. Default 0.5: no kick is chosen by such a place.
    pub lost_deviation_m: f64,
    /// Most balls that are kept apart. Default 8.
    pub most_balls: usize,
}

impl Default for MemoryPreset {
    fn default() -> Self {
        Self {
            confirm: 3,
            found_factor: 4.0,
            missed_factor: 0.6,
            most_odds: 100.0,
            lost_odds: 0.5,
            seen_s: 0.2,
            forget_s: 20.0,
            lost_deviation_m: 0.5,
            most_balls: 8,
        }
    }
}

impl MemoryPreset {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValueError> {
        within("found_factor", self.found_factor, [1.0, 1e3], "1 or more")?;
        within("missed_factor", self.missed_factor, [1e-3, 1.0], "above 0 and at most 1")?;
        within("most_odds", self.most_odds, [1.0, 1e6], "1 or more")?;
        within("lost_odds", self.lost_odds, [1e-6, 1.0], "above 0 and at most 1")?;
        within("seen_s", self.seen_s, [0.0, 10.0], "0 to 10 s")?;
        within("forget_s", self.forget_s, [0.0, 1e4], "0 or more")?;
        within("lost_deviation_m", self.lost_deviation_m, [1e-3, 100.0], "a positive number")?;
        if self.confirm == 0 {
            return Err(ValueError::new("confirm", "at least 1 image", self.confirm));
        }
        if self.most_balls == 0 {
            return Err(ValueError::new("most_balls", "at least 1", self.most_balls));
        }
        Ok(())
    }
}
