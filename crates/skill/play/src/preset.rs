//! What of a task's preset says how its policy is played.

use std::collections::BTreeMap;

use paid_policy::observation::ObservationId;
use paid_track::EyesPreset;

use crate::{AfterStrikePreset, OwnPlace};

/// How a policy is played: what a player needs of the task that the policy was trained in.
#[derive(Clone, Debug, PartialEq)]
pub struct PlayPreset {
    /// Name of the task.
    pub name: String,
    /// Terms of the policy's observation.
    pub observations: Vec<ObservationId>,
    /// Control period `[s]`.
    pub dt_s: f64,
    /// True if there is a ball to kick.
    pub has_ball: bool,
    /// Radius of the ball `[m]`.
    pub ball_radius_m: f64,
    /// Rate at which the ball slows down while it rolls `[1/s]`, see [`paid_track::roll_decay`].
    pub ball_decay: f64,
    /// Where a motion's own ball is.
    pub own_place: OwnPlace,
    /// When the policy's foot meets a ball, by the motion's name, in seconds from its first frame.
    pub contact_s: BTreeMap<String, f64>,
    /// True: a kick of the left foot is played as the mirror image of one of the right foot.
    pub mirror_left_kicks: bool,
    /// What is shown of the ball after the strike.
    pub after_strike: AfterStrikePreset,
    /// The ball tracker, and the simulated camera and odometry.
    pub eyes: EyesPreset,
}

impl PlayPreset {
    /// True if the policy sees a rolling ball where it will be when the reference strikes; motions are chosen by that place then.
    pub fn predicts_ball(&self) -> bool {
        self.observations.contains(&ObservationId::BallAtStrike)
    }
}
