//! Where the robot stands for a kick, and whether it reaches the ball from there.

use paid_eval::episodes::EvalSetup;
use paid_eval::metrics::shooting::Goal;
use paid_eval::shooting::{Grid, Placement};
use paid_play::RollingBall;
use paid_task::roll_decay;

use crate::Pose2;
use crate::pose2::wrapped;

/// How far beyond the protocols' workspace a ball may lie `[m]`.
const SLACK_M: f64 = 0.12;
/// The goal is at most so far off the robot's heading `[rad]`.
const BEARING_RAD: f64 = 0.45;
/// Nearest and farthest goal from the robot `[m]`.
const GOAL_M: [f64; 2] = [2.8, 9.0];
/// Where the protocols put the goal, ahead of the robot `[m]`.
const USUAL_GOAL_M: f64 = 5.0;
/// Where a ball lies before a robot that is carried to it `[m]`.
const BEFORE_M: f64 = 1.1;

/// True if a ball at `place` of the robot's axes is in the workspace.
pub(super) fn reaches(place: [f64; 2]) -> bool {
    let Grid { x, y, .. } = Grid::EFFECTIVE;
    let within = |v: f64, [low, high]: [f64; 2]| (low - SLACK_M..=high + SLACK_M).contains(&v);
    within(place[0], x) && within(place[1], y)
}

/// Where a rolling ball will be when it is met in the clip that is chosen for it, robot's axes `[m]`.
pub(super) fn at_strike(
    setup: &EvalSetup,
    place: [f64; 2],
    velocity: [f64; 2],
    clip: Option<usize>,
) -> [f64; 2] {
    if velocity == [0.0; 2] {
        return place;
    }
    let motion = clip.unwrap_or_else(|| Placement::new(setup).motion(0, 0, place, velocity));
    let ball = RollingBall { place, velocity, decay: roll_decay(&setup.ball()) };
    ball.at_strike(&setup.library.facts()[motion], 0, setup.preset.control_dt_s())
}

/// True if the goal is ahead of a robot at `pose`, neither too near nor too far.
pub(super) fn faces(pose: &Pose2, goal: [f64; 2]) -> bool {
    let [x, y] = pose.local(goal);
    y.atan2(x).abs() <= BEARING_RAD && (GOAL_M[0]..=GOAL_M[1]).contains(&x.hypot(y))
}

/// The place from which a ball lies ahead in the direction of the goal.
pub(super) fn behind(ball: [f64; 2], goal: [f64; 2]) -> Pose2 {
    let heading = wrapped((goal[1] - ball[1]).atan2(goal[0] - ball[0]));
    let (s, c) = heading.sin_cos();
    Pose2 { xy: [ball[0] - BEFORE_M * c, ball[1] - BEFORE_M * s], heading }
}

/// The origin with the goal ahead, or, if the goal is too near or too far for that, a place at the usual distance before it.
pub(super) fn home(goal: &Goal) -> Pose2 {
    let [x, y] = goal.center;
    let origin = Pose2 { xy: [0.0; 2], heading: y.atan2(x) };
    if faces(&origin, goal.center) {
        return origin;
    }
    let (s, c) = goal.heading.sin_cos();
    Pose2 { xy: [x - USUAL_GOAL_M * c, y - USUAL_GOAL_M * s], heading: goal.heading }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn the_workspace_is_the_protocols_and_a_little_more() {
        assert!(reaches([0.4, 1.1]) && reaches([2.1, 0.0]));
        assert!(!reaches([0.3, 0.0]) && !reaches([1.0, -1.2]) && !reaches([-1.0, 0.0]));
    }

    #[test]
    fn a_robot_is_carried_behind_the_ball_and_looks_at_the_goal() {
        let pose = behind([2.0, 1.0], [2.0, 6.0]);
        assert!((pose.heading - FRAC_PI_2).abs() < 1e-12);
        let [x, y] = pose.local([2.0, 1.0]);
        assert!((x - BEFORE_M).abs() < 1e-12 && y.abs() < 1e-12);
        assert!(faces(&pose, [2.0, 6.0]) && !faces(&pose, [6.0, 1.0]));
    }

    #[test]
    fn a_goal_that_is_too_near_moves_the_robot_away() {
        let goal = Goal { center: [1.0, 0.0], heading: 0.0, half_width: 1.0 };
        assert_eq!(home(&goal).xy, [-4.0, 0.0]);
        let aside = Goal { center: [0.0, 5.0], heading: FRAC_PI_2, half_width: 1.0 };
        assert_eq!(home(&aside).xy, [0.0; 2]);
        assert!((home(&aside).heading - FRAC_PI_2).abs() < 1e-12);
    }
}
