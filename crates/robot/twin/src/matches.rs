//! A match over the link: kick after kick, and the robot is not touched.

use std::sync::Arc;
use std::sync::atomic::Ordering;

use paid_eval::matches::{MatchBall, MatchOptions as Field};
use paid_eval::metrics::shooting::Goal;
use paid_eval::shooting::robot_distance;
use paid_lanes::Vec3;
use paid_lanes::rng::Rng;
use paid_runtime::log::LogWriter;
use paid_runtime::{Event, Latency, Player, State};
use paid_track::{Camera, CameraPreset};

use crate::TwinError;
use crate::lockstep::{Lockstep, LockstepOptions};
use crate::robot::VirtualG1;
use crate::senses::TrueState;
use crate::serve::Watcher;
use crate::shot::{KickResult, Shot};

/// Redraws of a ball before the match ends for want of room.
const REDRAWS: usize = 1000;
/// A ball is put elsewhere this many times in a row before it counts that the robot does not see it.
pub(crate) const IN_VAIN: usize = 5;
/// The text for a ball that was put down and that the robot has not seen.
const NOT_SEEN: &str = "none: waited for a ball";
/// What is played.
#[derive(Clone, Debug)]
pub struct MatchOptions {
    /// Runtime and senses. The balls are those of the evaluation's match with this number and seed 0, as long as there is room for them.
    pub lockstep: LockstepOptions,
    /// Kicks, balls, goal: the evaluation's own match.
    pub field: Field,
}

impl Default for MatchOptions {
    /// Eleven kicks as in the paper: its effective workspace, a goal 5 m ahead.
    fn default() -> Self {
        Self { lockstep: LockstepOptions::default(), field: Field { kicks: 11, ..Field::default() } }
    }
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
    /// From the capture of an image to joint targets.
    pub latency: Latency,
}

impl MatchResult {
    /// Goals.
    pub fn goals(&self) -> usize {
        self.kicks.iter().filter(|kick| kick.goal).count()
    }
}

/// Plays a match in lockstep: gantry, stand up, let go, and then ball after ball. `watcher` looks on. A match that is stopped
/// ([`LockstepOptions::stop`]) has the kicks before that; the log is finished.
///
/// # Errors
/// If MuJoCo is missing, or the robot cannot be made ready.
pub fn play_match(
    player: &Arc<Player>,
    options: &MatchOptions,
    log: Option<LogWriter>,
    watcher: Option<Box<dyn Watcher>>,
    mut told: impl FnMut(&KickResult),
) -> Result<MatchResult, TwinError> {
    let mut step = Lockstep::new(player, &options.lockstep)?;
    if let Some(log) = log {
        step.set_log(log);
    }
    if let Some(watcher) = watcher {
        step.set_watcher(watcher);
    }
    let mut rng = MatchBall::rng(0, options.lockstep.seed as u32);
    let mut result = MatchResult {
        kicks: Vec::new(),
        stopped: None,
        peak: [0.0; 4],
        seconds: 0.0,
        events: Vec::new(),
        latency: Latency::default(),
    };
    let told_to_stop = || options.lockstep.stop.load(Ordering::Relaxed);
    let ready = step.make_ready(true);
    let (mut unseen, mut in_vain) = (0, 0);
    while ready.is_ok() && result.kicks.len() < options.field.kicks {
        let sees = camera(player, step.has_own_eyes());
        let Some((ball, out_of_view)) = next_ball(player, &step.robot, &sees, &options.field, &mut rng)
        else {
            result.stopped = Some("no place for a ball".to_owned());
            break;
        };
        unseen += out_of_view;
        let mut kick = one_kick(&mut step, &options.field, &ball)?;
        let stopped = step.runtime().state() == State::Damping;
        if told_to_stop() && !kick.goal {
            // It was not played to its end.
            break;
        }
        if kick.motion == NOT_SEEN && !stopped && in_vain < IN_VAIN {
            // It sways: a ball at the image's edge may be out of it again.
            (unseen, in_vain) = (unseen + 1, in_vain + 1);
            continue;
        }
        in_vain = 0;
        kick.out_of_view = std::mem::take(&mut unseen);
        told(&kick);
        result.kicks.push(kick);
        if stopped {
            break;
        }
    }
    result.stopped = step.runtime().why().map(ToString::to_string).or(result.stopped);
    result.peak = step.peak();
    result.seconds = step.robot.now_us() as f64 * 1e-6;
    result.events = step.events().to_vec();
    result.latency = step.runtime().latency().clone();
    if let Some(log) = step.take_log() {
        log.finish()?;
    }
    if told_to_stop() { Ok(result) } else { ready.map(|()| result) }
}

/// The camera that has to see a ball: that of training's senses, or that of onboard perception, which tells a ball from other things by
/// its color.
pub(crate) fn camera(player: &Player, own_eyes: bool) -> Camera {
    if own_eyes { CameraPreset::color().geometry() } else { player.play.eyes.camera.geometry() }
}

/// The next ball that does not touch the robot and is in its camera's image, and how many were drawn that are not.
pub(crate) fn next_ball(
    player: &Player,
    robot: &VirtualG1,
    camera: &Camera,
    field: &Field,
    rng: &mut Rng,
) -> Option<(MatchBall, usize)> {
    let (truth, radius) = (robot.true_state(), player.play.ball_params.radius_m);
    let [near, far] = player.play.eyes.range_m;
    let mut out_of_view = 0;
    for _ in 0..REDRAWS {
        let ball = field.draw_ball(rng);
        let [x, y] = placed(&truth, ball.ball_xy);
        let center = [x, y, radius];
        let poses = robot.truth().bodies.iter().map(|body| (body.pos.0, body.rot));
        if robot_distance(&player.model, poses, center) < radius {
            continue;
        }
        let seen = truth.torso.point_in_body(Vec3(center));
        let range = (seen - camera.mount()).norm();
        if camera.sees(seen) && near <= range && range <= far {
            return Some((ball, out_of_view));
        }
        out_of_view += 1;
    }
    None
}

/// A point of the robot's axes in the world `[m]`.
pub(crate) fn placed(truth: &TrueState, [ahead, left]: [f64; 2]) -> [f64; 2] {
    let (s, c) = truth.torso.rot.yaw().sin_cos();
    let [x, y, _] = truth.torso.pos.0;
    [x + c * ahead - s * left, y + s * ahead + c * left]
}

/// A ball before its goal, whose plane is perpendicular to the robot's heading at the begin.
pub(crate) fn shot(truth: &TrueState, field: &Field, next: &MatchBall) -> Shot {
    let (at, center) = (placed(truth, next.ball_xy), placed(truth, next.goal_xy));
    let goal = Goal { center, heading: truth.torso.rot.yaw(), half_width: field.goal_half_width_m };
    Shot::new(goal, at, next.ball_xy)
}

fn one_kick(step: &mut Lockstep, field: &Field, next: &MatchBall) -> Result<KickResult, TwinError> {
    let begin_us = step.robot.now_us();
    let truth = step.truth();
    let [vx, vy] = next.ball_velocity;
    let (s, c) = truth.torso.rot.yaw().sin_cos();
    let mut shot = shot(&truth, field, next);
    step.robot.place_ball(placed(&truth, next.ball_xy), [c * vx - s * vy, s * vx + c * vy]);
    step.place_goal(shot.goal_center())?;
    let before = step.runtime().kicks();
    let began = step.run_until(field.patience_s + 5.0, |s| {
        s.runtime().kicks() > before || s.runtime().state() == State::Damping
    })?;
    if began && step.runtime().state() == State::Kick {
        if let Some(motion) = step.runtime().motion() {
            shot.result.motion.clone_from(&step.player().library.facts()[motion].name);
        }
        shot.result.ball_error_m = step.ball_error_m();
        let mut ready_us = None;
        let patience_us = (field.patience_s * 1e6) as u64;
        step.run_until(60.0, |s| {
            shot.step(s.robot.truth());
            match s.runtime().state() {
                State::Damping => true,
                State::Ready => {
                    let since = *ready_us.get_or_insert(s.robot.now_us());
                    shot.is_over() || s.robot.now_us() - since > patience_us
                }
                _ => false,
            }
        })?;
    }
    let mut result = shot.result;
    if result.motion.is_empty() {
        result.motion = format!("none: waited for {}", step.runtime().waiting());
    }
    result.seconds = (step.robot.now_us() - begin_us) as f64 * 1e-6;
    Ok(result)
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_runtime::PlayerSpec;

    #[test]
    fn balls_are_the_judges_as_far_as_the_robot_sees_them_and_does_not_stand_on_them() {
        let test = "balls_are_the_judges_as_far_as_the_robot_sees_them_and_does_not_stand_on_them";
        if paid_testing::mujoco(test, paid_mujoco::Library::get()).is_none() {
            return;
        }
        let policy =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
        let player = Player::load(&PlayerSpec { policy, motions: None, sets: Vec::new() }).expect("policy");
        let step = Lockstep::new(&Arc::new(player), &LockstepOptions::default()).expect("MuJoCo");
        // From a step ahead of the toes to twice as far as the camera sees: 0.5 to 2.4 m.
        let mut field = Field::default();
        field.workspace.x = [0.0, 4.8];
        let (mut ours, mut judges) = (MatchBall::rng(0, 7), MatchBall::rng(0, 7));
        let camera = camera(step.player(), false);
        let (mut drawn, mut hidden) = (0, 0);
        for _ in 0..50 {
            let (ball, out_of_view) =
                next_ball(step.player(), &step.robot, &camera, &field, &mut ours).expect("room");
            let [x, y] = placed(&step.truth(), ball.ball_xy);
            assert!(camera.sees(step.truth().torso.point_in_body(Vec3([x, y, 0.11]))), "{ball:?}");
            assert!((0.4..2.6).contains(&ball.ball_xy[0]), "{ball:?}");
            // The evaluation's next ball that fits is this one.
            let passed = (0..REDRAWS).take_while(|_| field.draw_ball(&mut judges) != ball).count();
            assert!(passed >= out_of_view, "{passed} {out_of_view}");
            (drawn, hidden) = (drawn + passed + 1, hidden + out_of_view);
        }
        assert!(drawn < 1000 && (0.3..0.8).contains(&(f64::from(hidden as u32) / f64::from(drawn as u32))));
    }
}
