//! A match over the link: kick after kick, and nobody touches the robot.

use std::sync::Arc;

use paid_lanes::rng::Rng;

use super::lockstep::{Lockstep, LockstepOptions};
use crate::DeployError;
use crate::log::LogWriter;
use crate::player::Player;
use crate::runtime::{Event, State};

/// Random stream of the balls.
const STREAM: u32 = 0x0B03;
/// A ball slower than this lies still `[m/s]`.
const AT_REST: f64 = 0.05;
/// A ball faster than this was struck `[m/s]`.
const STRUCK: f64 = 0.5;

/// What is played.
#[derive(Clone, Debug)]
pub struct MatchOptions {
    /// Kicks.
    pub kicks: usize,
    /// Runtime and senses.
    pub lockstep: LockstepOptions,
    /// Balls lie in this rectangle ahead of the torso `[m]` ...
    pub ahead_m: [f64; 2],
    /// ... and so far to its left `[m]`.
    pub left_m: [f64; 2],
    /// Distance of the goal `[m]`.
    pub goal_distance_m: f64,
    /// The goal is up to so far off straight ahead `[rad]`.
    pub goal_bearing_rad: f64,
    /// Half of the goal's width `[m]`.
    pub goal_half_width_m: f64,
    /// The next ball comes at the latest so long after the robot is ready `[s]`.
    pub patience_s: f64,
}

impl Default for MatchOptions {
    /// Eleven kicks as in the paper: its effective workspace, a goal 5 m ahead.
    fn default() -> Self {
        Self {
            kicks: 11,
            lockstep: LockstepOptions::default(),
            ahead_m: [0.5, 2.0],
            left_m: [-1.0, 1.0],
            goal_distance_m: 5.0,
            goal_bearing_rad: 10_f64.to_radians(),
            goal_half_width_m: 1.0,
            patience_s: 5.0,
        }
    }
}

/// What came of a kick.
#[derive(Clone, Debug, PartialEq)]
pub struct KickResult {
    /// The ball ahead of the torso and to its left `[m]`.
    pub ball: [f64; 2],
    /// Name of the motion, or what the robot waited for in vain.
    pub motion: String,
    /// How far off the runtime believed the ball to be when it began `[m]`.
    pub ball_error_m: f64,
    /// The ball was struck.
    pub struck: bool,
    /// It went into the goal.
    pub goal: bool,
    /// Simulated time `[s]`.
    pub seconds: f64,
}

/// What came of a match.
#[derive(Clone, Debug)]
pub struct MatchResult {
    /// Kick by kick.
    pub kicks: Vec<KickResult>,
    /// Why the robot damped before the end, if it did.
    pub stopped: Option<String>,
    /// Highest tilt `[rad]`, gyro `[rad/s]`, joint speed and torque (shares of their limits) under the policy.
    pub peak: [f64; 4],
    /// Simulated time `[s]`.
    pub seconds: f64,
    /// Every transition.
    pub events: Vec<Event>,
}

impl MatchResult {
    /// Goals.
    pub fn goals(&self) -> usize {
        self.kicks.iter().filter(|kick| kick.goal).count()
    }
}

/// Plays a match in lockstep: gantry, stand up, let go, and then ball after ball.
///
/// # Errors
/// If MuJoCo is missing, or the robot cannot be made ready.
pub fn play_match(
    player: &Arc<Player>,
    options: &MatchOptions,
    log: Option<LogWriter>,
    mut told: impl FnMut(&KickResult),
) -> Result<MatchResult, DeployError> {
    let mut step = Lockstep::new(player, &options.lockstep)?;
    if let Some(log) = log {
        step.set_log(log);
    }
    let mut rng = Rng::new(options.lockstep.seed, 0, STREAM);
    let mut result =
        MatchResult { kicks: Vec::new(), stopped: None, peak: [0.0; 4], seconds: 0.0, events: Vec::new() };
    let ready = step.make_ready(true);
    while ready.is_ok() && result.kicks.len() < options.kicks {
        let kick = one_kick(&mut step, options, &mut rng)?;
        told(&kick);
        result.kicks.push(kick);
        if step.runtime().state() == State::Damping {
            break;
        }
    }
    result.stopped = step.runtime().why().map(ToString::to_string);
    result.peak = step.peak();
    result.seconds = step.robot.now_us() as f64 * 1e-6;
    result.events = step.events().to_vec();
    if let Some(log) = step.take_log() {
        log.finish()?;
    }
    ready.map(|()| result)
}

fn one_kick(step: &mut Lockstep, options: &MatchOptions, rng: &mut Rng) -> Result<KickResult, DeployError> {
    let begin_us = step.robot.now_us();
    let truth = step.truth();
    let ([x, y, _], ahead) = (truth.torso.pos.0, truth.torso.rot.yaw());
    let (s, c) = ahead.sin_cos();
    let world = |[a, l]: [f64; 2]| [x + c * a - s * l, y + s * a + c * l];
    let feet = step.player().spec.feet.clone().map(|foot| {
        let body = step.player().model.body_index(&foot).unwrap_or(0);
        step.robot.truth().bodies[body].pos
    });
    let free = |[bx, by]: [f64; 2]| feet.iter().all(|f| (bx - f.x()).hypot(by - f.y()) > 0.3);
    let mut ball = [1.0, 0.0];
    for _ in 0..100 {
        let [near, far] = options.ahead_m;
        let [right, left] = options.left_m;
        ball = [rng.uniform(near, far), rng.uniform(right, left)];
        if free(world(ball)) {
            break;
        }
    }
    let bearing = rng.uniform(-options.goal_bearing_rad, options.goal_bearing_rad);
    let goal = world([options.goal_distance_m * bearing.cos(), options.goal_distance_m * bearing.sin()]);
    let at = world(ball);
    step.robot.place_ball(at, [0.0; 2]);
    step.place_goal(goal)?;
    let before = step.runtime().kicks();
    let began = step.run_until(options.patience_s + 5.0, |s| {
        s.runtime().kicks() > before || s.runtime().state() == State::Damping
    })?;
    let mut result = KickResult {
        ball,
        motion: String::new(),
        ball_error_m: f64::NAN,
        struck: false,
        goal: false,
        seconds: 0.0,
    };
    if began && step.runtime().state() == State::Kick {
        if let Some(motion) = step.runtime().motion() {
            result.motion.clone_from(&step.player().library.facts()[motion].name);
        }
        if let Some(believed) = step.runtime().ball() {
            let placed = step.senses.placed(at, &step.truth());
            result.ball_error_m = (believed[0] - placed[0]).hypot(believed[1] - placed[1]);
        }
        // Along the robot's heading at the begin: the goal's plane is perpendicular to it.
        let ahead_of = |p: [f64; 2]| c * (p[0] - goal[0]) + s * (p[1] - goal[1]);
        let left_of = |p: [f64; 2]| c * (p[1] - goal[1]) - s * (p[0] - goal[0]);
        let (mut last, mut crossed, mut ready_us) = (at, false, None);
        let patience_us = (options.patience_s * 1e6) as u64;
        step.run_until(60.0, |s| {
            let truth = s.robot.truth();
            let ([bx, by, _], [vx, vy, _]) = (truth.ball.pos.0, truth.ball.vel.0);
            let speed = vx.hypot(vy);
            result.struck |= speed > STRUCK;
            let (from, to) = (ahead_of(last), ahead_of([bx, by]));
            if result.struck && !crossed && from < 0.0 && to >= 0.0 {
                crossed = true;
                let share = from / (from - to);
                let side = left_of(last) + share * (left_of([bx, by]) - left_of(last));
                result.goal = side.abs() <= options.goal_half_width_m;
            }
            last = [bx, by];
            match s.runtime().state() {
                State::Damping => true,
                State::Ready => {
                    let since = *ready_us.get_or_insert(s.robot.now_us());
                    crossed || speed < AT_REST || s.robot.now_us() - since > patience_us
                }
                _ => false,
            }
        })?;
    }
    if result.motion.is_empty() {
        result.motion = format!("none: waited for {}", step.runtime().waiting());
    }
    result.seconds = (step.robot.now_us() - begin_us) as f64 * 1e-6;
    Ok(result)
}
