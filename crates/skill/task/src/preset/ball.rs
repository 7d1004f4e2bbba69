//! Where ball and goal are at the start.

use std::collections::BTreeMap;

use paid_play::{AfterStrikePreset, OwnPlace};
use serde::{Deserialize, Serialize};

use crate::TaskError;
use crate::preset::numbers::{LENGTH, PLACE, POSITIVE_LENGTH, SHARE, SPEED, check};
use crate::preset::{Range, ReferenceSource, value_error};

/// Which balls belong to which motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum BallRule {
    /// The way to the motion's own place, turned and stretched (paper, appendix A).
    Arc,
    /// Uniform in a rectangle ahead of the robot, kicked with the motion whose own place is nearest, as in the
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
    /// Where a motion's own ball is, which the rules below are about.
    #[serde(default)]
    pub own_place: OwnPlace,
    /// `workspace`: range ahead of the first frame's anchor, along its heading `[m]`. The evaluation's effective workspace and a quarter of
    /// a meter around it is 0.25 to 2.25, and -1.25 to 1.25 to the left.
    pub ahead_m: Range,
    /// `workspace`: range to its left `[m]`.
    pub left_m: Range,
    /// `arc`: half-width of the uniform angle offset `[degrees]`.
    pub angle_deg: f64,
    /// `arc`: half-width of the uniform radius offset `[m]`.
    pub radius_m: f64,
    /// `workspace`: share, among the episodes that draw their motion first, of those whose ball lies within 0.3 m of the motion's own place
    /// in x and in y, also where another motion's place is nearer. Where a motion's neighbors leave it a sliver of the workspace,
    /// the policy learns only that sliver.
    #[serde(default)]
    pub own_place_share: f64,
    /// `workspace`: initial share of a ball's distance from its motion's nominal place by which it is moved; 1 puts it where it was
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
    /// When the policy's foot meets a ball, by the motion's name, in seconds from its first frame; a motion that is not named has the time of
    /// its strike. A rolling ball is predicted until then. Empty during training, whose end measures it.
    #[serde(default)]
    pub contact_s: BTreeMap<String, f64>,
    /// What policy and critic are shown of the ball after the strike, in training and in evaluations.
    #[serde(default)]
    pub after_strike: AfterStrikePreset,
}

impl BallPlacement {
    pub(crate) fn check(&self) -> Result<(), TaskError> {
        check(
            "ball",
            &[
                ("ahead_m", self.ahead_m.into(), PLACE),
                ("left_m", self.left_m.into(), PLACE),
                ("angle_deg", self.angle_deg.into(), ([0.0, 180.0], "0 to 180 degrees")),
                ("radius_m", self.radius_m.into(), LENGTH),
                ("own_place_share", self.own_place_share.into(), SHARE),
                ("spread_from", self.spread_from.into(), SHARE),
                ("spread_at", self.spread_at.into(), SHARE),
                ("velocity", self.velocity.into(), SPEED),
                ("rolling_share", self.rolling_share.into(), SHARE),
                ("clearance_m", self.clearance_m.into(), LENGTH),
            ],
        )
    }
}

/// Refuses times out of range, and a rule about a strike in a task without one.
pub(crate) fn check_after_strike(
    rule: &AfterStrikePreset,
    reference: ReferenceSource,
) -> Result<(), TaskError> {
    rule.check()?;
    if rule.times().is_some() && reference == ReferenceSource::None {
        let expected = "'ball' in a task without a reference, which has no strike";
        return Err(value_error("ball.after_strike.show", expected, "'where_it_lay'".into()));
    }
    Ok(())
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

impl GoalPreset {
    pub(crate) fn check(&self) -> Result<(), TaskError> {
        check(
            "goal",
            &[
                ("distance_m", self.distance_m.into(), POSITIVE_LENGTH),
                ("rectangle_across_m", self.rectangle_across_m.into(), LENGTH),
                ("rectangle_along_m", self.rectangle_along_m.into(), LENGTH),
                ("width_m", self.width_m.into(), POSITIVE_LENGTH),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use paid_play::ShownAfterStrike;

    use super::*;

    #[test]
    fn a_rule_without_a_strike_or_with_a_negative_time_is_refused() {
        let rule = AfterStrikePreset { show: ShownAfterStrike::WhereItLay, ..AfterStrikePreset::default() };
        check_after_strike(&rule, ReferenceSource::Motions).expect("valid");
        let error = check_after_strike(&rule, ReferenceSource::None).expect_err("no strike").to_string();
        assert!(
            error.starts_with("preset: ball.after_strike.show is 'where_it_lay', expected 'ball'"),
            "{error}"
        );
        check_after_strike(&AfterStrikePreset::default(), ReferenceSource::None).expect("the ball as it is");
        let error = check_after_strike(&AfterStrikePreset { from_s: -0.1, ..rule }, ReferenceSource::Motions);
        let error = error.expect_err("negative").to_string();
        assert_eq!(error, "preset: ball.after_strike.from_s is -0.1, expected 0 to 5 s");
    }
}
