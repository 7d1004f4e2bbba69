//! Which ball, which goal, which motion.

use std::f64::consts::TAU;

use paid_lanes::rng::Rng;
use paid_task::{EnvSample, InitialState, NextKick};

use super::MatchOptions;
use crate::episodes::EvalSetup;
use crate::shooting::Placement;
use crate::{EvalError, Setting};

/// Redraws of a ball before a workspace counts as full.
const REDRAWS: usize = 1000;
/// Random stream of the matches.
const STREAM: u32 = 0x5108;

/// A ball that appears to a robot, and the goal that it is for. Axes: origin on the ground below the robot's anchor, x along its heading, y left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatchBall {
    /// Ball center `[m]`.
    pub ball_xy: [f64; 2],
    /// Ball velocity `[m/s]`.
    pub ball_velocity: [f64; 2],
    /// Goal center `[m]`.
    pub goal_xy: [f64; 2],
}

impl MatchBall {
    /// The random numbers of match `number`: each player of it draws the same balls.
    pub fn rng(seed: u64, number: u32) -> Rng {
        Rng::new(seed, number, STREAM)
    }
}

impl MatchOptions {
    /// Draws a ball and a goal anywhere in their ranges; the caller checks whether there is room.
    pub fn draw_ball(&self, rng: &mut Rng) -> MatchBall {
        let ball_xy = [
            rng.uniform(self.workspace.x[0], self.workspace.x[1]),
            rng.uniform(self.workspace.y[0], self.workspace.y[1]),
        ];
        let (speed, direction) = (rng.unit(), TAU * rng.unit());
        let ball_velocity = self.rolling.map_or([0.0; 2], |[lo, hi]| {
            let v = lo + (hi - lo) * speed;
            [v * direction.cos(), v * direction.sin()]
        });
        let bearing = rng.uniform(-self.goal_bearing_deg, self.goal_bearing_deg).to_radians();
        let goal_xy = [self.goal_distance_m * bearing.cos(), self.goal_distance_m * bearing.sin()];
        MatchBall { ball_xy, ball_velocity, goal_xy }
    }
}

/// The kicks of one match. They depend on the seed, the match's number and, where a ball would touch the robot, on how it stands.
#[derive(Clone, Debug)]
pub(super) struct Draw<'a> {
    placement: Placement<'a>,
    options: &'a MatchOptions,
    number: usize,
    /// Number of the ball that is drawn.
    look: u64,
    rng: Rng,
}

impl<'a> Draw<'a> {
    pub(super) fn new(setup: &'a EvalSetup, options: &'a MatchOptions, number: usize) -> Self {
        // A stream of its own: the numbers must not be those of the environment's resets.
        let rng = MatchBall::rng(setup.seed, number as u32);
        Self { placement: Placement::new(setup), options, number, look: 0, rng }
    }

    /// Number of the match.
    pub(super) fn number(&self) -> usize {
        self.number
    }

    /// The next kick whose ball is `free` for its motion.
    fn kick(&mut self, free: impl Fn(&Placement<'_>, &NextKick) -> bool) -> Option<NextKick> {
        (0..REDRAWS).find_map(|_| {
            let kick = self.any();
            free(&self.placement, &kick).then_some(kick)
        })
    }

    fn any(&mut self) -> NextKick {
        let MatchBall { ball_xy, ball_velocity, goal_xy } = self.options.draw_ball(&mut self.rng);
        NextKick {
            motion: self.placement.motion(self.number, self.look, ball_xy, ball_velocity),
            ball_xy,
            ball_velocity,
            goal_xy,
            look: self.look,
        }
    }

    /// The next kick of a robot that stands as it does; `anchor` is the anchor's body. `None` if no ball has room.
    pub(super) fn next(&mut self, sample: &EnvSample, anchor: usize) -> Option<NextKick> {
        self.look += 1;
        self.kick(|placement, kick| !placement.touches(sample, anchor, kick.ball_xy))
    }
}

/// The first kick, from the first frame of its motion.
pub(super) fn first_start(draw: &mut Draw<'_>) -> Result<InitialState, EvalError> {
    let kick = draw.kick(|placement, kick| !placement.overlaps(kick.motion, kick.ball_xy));
    let NextKick { motion, ball_xy, ball_velocity, goal_xy, look: _ } =
        kick.ok_or_else(|| EvalError::Option {
            option: Setting::Named("workspace"),
            expected: "positions that leave room for the ball next to the robot".to_owned(),
            found: format!("{:?}", draw.options.workspace),
        })?;
    Ok(InitialState {
        ball_xy: Some(ball_xy),
        ball_velocity,
        goal_xy: Some(goal_xy),
        ..InitialState::nominal(motion)
    })
}
