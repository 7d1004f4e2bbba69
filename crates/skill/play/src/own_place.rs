//! Where a motion's own ball is.

use serde::{Deserialize, Serialize};

/// Where a motion's own ball is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OwnPlace {
    /// Where the torso ends, as in the paper, whose kicks end where the ball was.
    #[default]
    TorsoEnd,
    /// Ahead of the foot in the frame of the strike ([`paid_motion::ball_ahead`]): for motions that continue to another place afterwards.
    Strike,
}
