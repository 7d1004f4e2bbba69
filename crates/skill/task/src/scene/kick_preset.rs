//! What counts as a kick.

use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::numbers::{Limits, SPEED, TIME, check};

/// What counts as a kick, and how long its outcome is rewarded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KickPreset {
    /// Force of the robot on the ball from which a contact counts `[N]`.
    pub contact_force_n: f64,
    /// Control steps for which direction and speed are rewarded after a correct-foot contact, the contact's own included.
    pub window_steps: usize,
    /// Control steps for which vertical speed is penalized once the ball is faster than `z_min_speed`.
    pub z_window_steps: usize,
    /// Ball speed that opens the vertical-speed window `[m/s]`.
    pub z_min_speed: f64,
    /// Horizontal ball speed below which direction and speed earn nothing `[m/s]` (paper: outcome terms are gated by a
    /// minimum ball speed; release: 0).
    pub min_ball_speed: f64,
    /// Horizontal ball speed from which direction is rewarded in full; below, in proportion to the speed `[m/s]`. 0: in full
    /// from `min_ball_speed` on, so that a ball that will not reach the goal earns as much as one that will.
    pub full_ball_speed: f64,
    /// How long before the reference's strike the first contact may come and still be rewarded `[s]`; 0: at any time. Otherwise a
    /// touch while walking earns a little, and is learned where the ball lies in the way of a step.
    pub early_s: f64,
    /// A first contact is rewarded only if the labeled foot's own body meets the ball, not its shin. Release: whichever foot is
    /// nearer counts as the one that met it.
    #[serde(default)]
    pub foot_only: bool,
    /// Whichever foot meets the ball first is rewarded, not only the labeled one; for ablations.
    #[serde(default)]
    pub any_foot: bool,
}

impl KickPreset {
    pub(crate) fn check(&self) -> Result<(), TaskError> {
        const STEPS: Limits = ([0.0, 1e4], "0 to 10000 steps");
        check(
            "rewards.kick",
            &[
                ("contact_force_n", self.contact_force_n.into(), ([0.0, 1e4], "0 to 10000 N")),
                ("window_steps", self.window_steps.into(), STEPS),
                ("z_window_steps", self.z_window_steps.into(), STEPS),
                ("z_min_speed", self.z_min_speed.into(), SPEED),
                ("min_ball_speed", self.min_ball_speed.into(), SPEED),
                ("full_ball_speed", self.full_ball_speed.into(), SPEED),
                ("early_s", self.early_s.into(), TIME),
            ],
        )
    }
}
