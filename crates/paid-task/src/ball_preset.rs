//! Where ball and goal are.

use serde::{Deserialize, Serialize};

use crate::preset::Range;

/// Which balls belong to which motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BallRule {
    /// The motion's torso displacement, turned and stretched (paper, appendix A).
    Arc,
    /// Uniform in a rectangle ahead of the robot, kicked with the motion whose torso displacement is nearest, as in the
    /// evaluation. Episodes from the first frame draw the ball first; others draw motion and phase first and then a ball that
    /// belongs to the motion, and begin displaced toward it by the share of the way to the strike that is behind them.
    Workspace,
}

/// Where the ball lies at the start.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BallPlacement {
    /// Which balls belong to which motion.
    pub rule: BallRule,
    /// `workspace`: range ahead of the first frame's anchor, along its heading `[m]`. The evaluation's effective workspace and a quarter of
    /// a meter around it is 0.25 to 2.25, and -1.25 to 1.25 to the left.
    pub ahead_m: Range,
    /// `workspace`: range to its left `[m]`.
    pub left_m: Range,
    /// `arc`: half-width of the uniform angle offset `[degrees]`.
    pub angle_deg: f64,
    /// `arc`: half-width of the uniform radius offset `[m]`.
    pub radius_m: f64,
    /// `workspace`: share of a ball's way from its motion's nominal place that it is moved at first; 1 puts it where it was
    /// drawn from the beginning. The share grows to 1 while the robot hits (below): a policy that can only follow its motion
    /// meets few balls elsewhere, and learns to avoid them.
    pub spread_from: f64,
    /// The share of the episodes of an iteration that must have sent the ball toward the goal for the balls to spread.
    pub spread_at: f64,
    /// Iterations with that success from the first share to 1.
    pub spread_iterations: u32,
    /// Half-width of the uniform initial velocity in x and in y `[m/s]`.
    pub velocity: f64,
    /// Share of episodes whose ball rolls at the start; the others' lies still.
    pub rolling_share: f64,
    /// Placements nearer than this to a foot (ankle to ball center, horizontally) are redrawn `[m]`.
    pub clearance_m: f64,
}

/// Where the goal is: uniform in a rectangle ahead of the motion's first frame (paper, section III-A).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalPreset {
    /// Center of the rectangle ahead of the motion's first base position, along its heading `[m]`.
    pub distance_m: f64,
    /// Side of the rectangle across the heading `[m]`.
    pub rectangle_across_m: f64,
    /// Side of the rectangle along the heading `[m]`.
    pub rectangle_along_m: f64,
    /// Width of the goal mouth for the goal statistics `[m]`.
    pub width_m: f64,
}
