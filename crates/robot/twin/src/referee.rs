//! The evaluation of a match over the wire. It knows the ground truth of robot and ball, and of the runtime only its commands, as the robot
//! does.

use std::sync::Arc;

use paid_eval::matches::{MatchBall, MatchOptions as Field};
use paid_lanes::rng::Rng;
use paid_runtime::Player;
use paid_runtime::wire::{DAMPING_KEYS, Key};
use paid_track::Camera;
use serde::Serialize;

use crate::matches::{IN_VAIN, camera, next_ball, shot};
use crate::robot::{Mount, VirtualG1};
use crate::serve::Order;
use crate::shot::{KickResult, Shot};

/// The robot stands still below this root mean square of joint speeds `[rad/s]`, as for the runtime ...
const STILL_RAD_S: f64 = 0.5;
/// ... for this long before a ball is laid `[s]` ...
const STILL_S: f64 = 1.0;
/// ... and for this long after it moved and the ball was not struck, which is a miss then `[s]`.
const MISSED_S: f64 = 3.0;
/// It moves if it is faster than this `[rad/s]`; holding a pose, it sways with less ...
const MOVES_RAD_S: f64 = 1.0;
/// ... for this long `[s]`.
const MOVES_S: f64 = 0.3;
/// A ball that was not struck this long after the robot began to move is missed, also if it sways on `[s]`.
const UNSTRUCK_S: f64 = 25.0;
/// A robot that sways gets its next ball after this long: the runtime itself waits 3 s `[s]`.
const SWAYS_S: f64 = 10.0;
/// Keys are pressed and the goal is sent again after this long, while nothing happens `[s]`.
const AGAIN_S: f64 = 2.0;
/// The first ball lies for this long at most: programs find each other, odometry begins `[s]`.
const FIRST_S: f64 = 90.0;
/// A kick takes this long at most `[s]`.
const KICK_S: f64 = 60.0;
/// After the last kick the stop keys are down for this long before it ends `[s]`.
const END_S: f64 = 0.3;

/// What is played.
#[derive(Clone, Debug)]
pub struct RefereeOptions {
    /// Kicks, balls, goal: the evaluation's own match.
    pub field: Field,
    /// Draws the balls: those of the evaluation's match with this number, as far as there is room for them.
    pub seed: u64,
    /// Balls are laid where the camera of onboard perception sees them, not that of training's senses.
    pub own_eyes: bool,
}

/// What came of the match.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Verdict {
    /// Kick by kick.
    pub kicks: Vec<KickResult>,
    /// The robot lay on the ground.
    pub fell: bool,
    /// The runtime, or the robot's own timeout, damped the robot before the end.
    pub stopped: bool,
    /// Simulated time `[s]`.
    pub seconds: f64,
}

impl Verdict {
    /// Goals.
    pub fn goals(&self) -> usize {
        self.kicks.iter().filter(|kick| kick.goal).count()
    }
}

enum Stage {
    /// Nothing holds the robot yet, or hands do.
    Begins,
    /// It goes back to standing still.
    Between,
    /// A ball lies, for a robot that stands.
    Laid(Box<Shot>),
    /// The robot moves.
    Kicks(Box<Shot>),
    /// The stop keys are pressed.
    Ends,
}

/// Lays ball after ball before a robot on the network, presses the remote's keys, and counts. The robot begins in hands ([`Mount::Hands`]).
pub struct Referee {
    player: Arc<Player>,
    options: RefereeOptions,
    camera: Camera,
    rng: Rng,
    stage: Stage,
    entered_us: u64,
    pressed_us: u64,
    goal_us: u64,
    still_us: u64,
    moving_us: u64,
    /// It was held once: from then on damping is an end.
    held: bool,
    in_vain: usize,
    unseen: usize,
    verdict: Verdict,
    untold: usize,
}

impl Referee {
    /// Before the match.
    pub fn new(player: &Arc<Player>, options: RefereeOptions) -> Self {
        Self {
            camera: camera(player, options.own_eyes),
            rng: MatchBall::rng(0, options.seed as u32),
            player: Arc::clone(player),
            options,
            stage: Stage::Begins,
            entered_us: 0,
            pressed_us: 0,
            goal_us: 0,
            still_us: 0,
            moving_us: 0,
            held: false,
            in_vain: 0,
            unseen: 0,
            verdict: Verdict::default(),
            untold: 0,
        }
    }

    /// The result so far.
    pub fn verdict(&self) -> &Verdict {
        &self.verdict
    }

    /// The next kick that was scored and not yet reported, with its number from 1.
    pub fn news(&mut self) -> Option<(usize, &KickResult)> {
        let kick = self.verdict.kicks.get(self.untold)?;
        self.untold += 1;
        Some((self.untold, kick))
    }

    fn enter(&mut self, robot: &VirtualG1, stage: Stage) {
        self.stage = stage;
        (self.entered_us, self.still_us, self.moving_us) = (robot.now_us(), 0, 0);
    }

    /// Looks at the robot; every 2 ms. What it wants done.
    pub fn step(&mut self, robot: &VirtualG1) -> Option<Order> {
        let step_us = crate::STEP_US;
        let speed = robot.joint_speed();
        self.still_us = if speed < STILL_RAD_S { self.still_us + step_us } else { 0 };
        self.moving_us = if speed > MOVES_RAD_S { self.moving_us + step_us } else { 0 };
        self.verdict.seconds = robot.now_us() as f64 * 1e-6;
        self.verdict.fell |= self.held && robot.lies();
        let held = holds(robot, self.player.joints());
        self.held |= held;
        if self.held && !held && !matches!(self.stage, Stage::Ends) {
            self.verdict.stopped = true;
            if let Stage::Laid(shot) | Stage::Kicks(shot) = std::mem::replace(&mut self.stage, Stage::Ends) {
                // A kick that had begun counts, as in the evaluation.
                if shot.result.struck || robot.joint_speed() > STILL_RAD_S {
                    self.judged(robot, *shot);
                }
            }
            self.enter(robot, Stage::Ends);
        }
        let since_s = (robot.now_us() - self.entered_us) as f64 * 1e-6;
        match std::mem::replace(&mut self.stage, Stage::Ends) {
            Stage::Begins => {
                self.stage = Stage::Begins;
                if self.held && robot.mount() == Mount::Free {
                    self.enter(robot, Stage::Between);
                }
                (!self.held).then(|| self.press(robot, &[Key::L2, Key::Up])).flatten()
            }
            Stage::Between => {
                self.stage = Stage::Between;
                (seconds(self.still_us) >= STILL_S || since_s > SWAYS_S).then(|| self.lay(robot)).flatten()
            }
            Stage::Laid(shot) => self.laid(robot, shot, since_s),
            Stage::Kicks(shot) => {
                self.kicks(robot, shot, since_s);
                None
            }
            Stage::Ends if since_s > END_S => Some(Order::Quit),
            Stage::Ends => self.press(robot, &DAMPING_KEYS),
        }
    }

    /// A ball for a robot that stands still.
    fn lay(&mut self, robot: &VirtualG1) -> Option<Order> {
        let found = next_ball(&self.player, robot, &self.camera, &self.options.field, &mut self.rng);
        let Some((ball, out_of_view)) = found else {
            self.enter(robot, Stage::Ends);
            return None;
        };
        self.unseen += out_of_view;
        let shot = shot(&robot.true_state(), &self.options.field, &ball);
        self.enter(robot, Stage::Laid(Box::new(shot)));
        (self.goal_us, self.pressed_us) = (0, robot.now_us());
        Some(Order::Ball(ball.ball_xy, ball.ball_velocity))
    }

    /// A ball that lies: the goal and the keys are sent again until the robot moves.
    fn laid(&mut self, robot: &VirtualG1, mut shot: Box<Shot>, since_s: f64) -> Option<Order> {
        shot.step(robot.truth());
        if seconds(self.moving_us) >= MOVES_S || shot.result.struck {
            self.enter(robot, Stage::Kicks(shot));
            return None;
        }
        let patience_s =
            if self.verdict.kicks.is_empty() { FIRST_S } else { self.options.field.patience_s + 5.0 };
        if since_s > patience_s {
            if self.in_vain < IN_VAIN {
                (self.unseen, self.in_vain) = (self.unseen + 1, self.in_vain + 1);
                self.enter(robot, Stage::Between);
            } else {
                "did not move".clone_into(&mut shot.result.motion);
                self.judged(robot, *shot);
            }
            return None;
        }
        let center = shot.goal_center();
        self.stage = Stage::Laid(shot);
        let now_us = robot.now_us();
        if self.goal_us == 0 || seconds(now_us - self.goal_us) >= AGAIN_S {
            self.goal_us = now_us;
            return Some(Order::Goal(ahead(robot, center)));
        }
        // Half a second later, so that the goal has arrived.
        (seconds(now_us - self.goal_us) >= 0.5).then(|| self.press(robot, &[Key::R1, Key::X])).flatten()
    }

    /// A robot that moves: until the ball has passed the goal's plane or lies still, and the robot stands still.
    fn kicks(&mut self, robot: &VirtualG1, mut shot: Box<Shot>, since_s: f64) {
        shot.step(robot.truth());
        let still_s = seconds(self.still_us);
        let over = if shot.result.struck {
            still_s >= STILL_S && (shot.is_over() || still_s > self.options.field.patience_s)
        } else {
            still_s >= MISSED_S || since_s > UNSTRUCK_S
        };
        if over || since_s > KICK_S {
            self.judged(robot, *shot);
        } else {
            self.stage = Stage::Kicks(shot);
        }
    }

    /// Writes down what came of a kick.
    fn judged(&mut self, robot: &VirtualG1, shot: Shot) {
        let mut result = shot.result;
        if result.motion.is_empty() {
            "moved".clone_into(&mut result.motion);
        }
        result.out_of_view = std::mem::take(&mut self.unseen);
        result.seconds = (robot.now_us() - self.entered_us) as f64 * 1e-6;
        self.in_vain = 0;
        self.verdict.kicks.push(result);
        let all = self.verdict.kicks.len() >= self.options.field.kicks;
        self.enter(robot, if all { Stage::Ends } else { Stage::Between });
    }

    /// Presses keys, now and then.
    fn press(&mut self, robot: &VirtualG1, keys: &[Key]) -> Option<Order> {
        let now_us = robot.now_us();
        let stops = keys == DAMPING_KEYS;
        if !stops && seconds(now_us - self.pressed_us) < AGAIN_S {
            return None;
        }
        self.pressed_us = now_us;
        Some(Order::Keys(keys.to_vec()))
    }
}

/// True while a command holds the joints.
fn holds(robot: &VirtualG1, joints: usize) -> bool {
    !robot.timed_out() && robot.command().motors[..joints].iter().any(|motor| motor.kp > 0.0)
}

fn seconds(us: u64) -> f64 {
    us as f64 * 1e-6
}

/// A point of the world (x, y) ahead of the torso and to its left `[m]`.
fn ahead(robot: &VirtualG1, [x, y]: [f64; 2]) -> [f64; 2] {
    let torso = robot.true_state().torso;
    let (s, c) = torso.rot.yaw().sin_cos();
    let [dx, dy] = [x - torso.pos.x(), y - torso.pos.y()];
    [c * dx + s * dy, c * dy - s * dx]
}
