//! A ball on its way, and what came of it.

use paid_eval::metrics::shooting::Goal;
use paid_physics::GroupState;
use serde::Serialize;

/// A ball slower than this lies still `[m/s]`.
const AT_REST: f64 = 0.05;
/// A ball faster than this was struck `[m/s]`.
const STRUCK: f64 = 0.5;

/// What came of a kick.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct KickResult {
    /// The ball ahead of the torso and to its left `[m]`.
    pub ball: [f64; 2],
    /// Name of the motion, or what the robot waited for in vain. Over the wire the name is unknown: whether it moved.
    pub motion: String,
    /// Places that were drawn before this one and lay outside the camera's image, or at its edge and were not seen. The evaluation's robot
    /// turns to every ball before it begins; this one holds its pose, so a ball is put where it can be seen.
    pub out_of_view: usize,
    /// Error of the runtime's estimate of the ball when it began `[m]`; not a number over the wire.
    pub ball_error_m: f64,
    /// The ball was struck.
    pub struck: bool,
    /// It went into the goal.
    pub goal: bool,
    /// How fast it was at most after it was struck `[m/s]`.
    pub ball_speed: f64,
    /// Where it passed the goal's plane, left of the middle `[m]`; `None` if it did not.
    pub lateral_m: Option<f64>,
    /// Simulated time `[s]`.
    pub seconds: f64,
}

/// A ball that lies before a goal, or rolls to it.
#[derive(Clone, Debug)]
pub(crate) struct Shot {
    goal: Goal,
    last: [f64; 2],
    speed: f64,
    /// As far as it has come.
    pub result: KickResult,
    crossed: bool,
}

impl Shot {
    /// A ball at this place of the world (x, y) `[m]`, which the robot has at `ball` ahead of its torso and to its left `[m]`.
    pub fn new(goal: Goal, at: [f64; 2], ball: [f64; 2]) -> Self {
        let result = KickResult {
            ball,
            motion: String::new(),
            out_of_view: 0,
            ball_error_m: f64::NAN,
            struck: false,
            goal: false,
            ball_speed: 0.0,
            lateral_m: None,
            seconds: 0.0,
        };
        Self { goal, last: at, speed: 0.0, result, crossed: false }
    }

    /// The goal's center (x, y) in the world `[m]`.
    pub fn goal_center(&self) -> [f64; 2] {
        self.goal.center
    }

    /// Looks at the ball; every 2 ms.
    pub fn step(&mut self, truth: &GroupState<f64>) {
        let ([x, y, _], [vx, vy, _]) = (truth.ball.pos.0, truth.ball.vel.0);
        self.speed = vx.hypot(vy);
        let result = &mut self.result;
        result.struck |= self.speed > STRUCK;
        result.ball_speed = result.ball_speed.max(self.speed);
        if let (true, false, Some(crossing)) =
            (result.struck, self.crossed, self.goal.crossing(self.last, [x, y]))
        {
            self.crossed = true;
            result.goal = crossing.inside;
            result.lateral_m = Some(crossing.lateral);
        }
        self.last = [x, y];
    }

    /// Nothing more is to be expected: it has passed the goal's plane, or lies still.
    pub fn is_over(&self) -> bool {
        self.crossed || self.speed < AT_REST
    }
}
