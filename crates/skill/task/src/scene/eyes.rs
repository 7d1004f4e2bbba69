//! Knowledge of ball and goal through simulated eyes: how the task's knobs reach [`paid_track::Eyes`].

use paid_lanes::rng::{Rng, fill_normal, fill_symmetric};
use paid_lanes::{Kernel, Mask, Real, Vec3};
use paid_physics::{BodyState, GroupState};
use paid_play::{BelievedScene, RollingBall};
use paid_policy::{Pose, SceneView};
use paid_track::{BallAtStart, BodyPose, Eyes, EyesNumbers, EyesPreset, TrueScene};
use serde::{Deserialize, Serialize};

use crate::config::TaskConfig;

/// What the policy knows of ball and goal, in training and in evaluations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum KnowledgeMode {
    /// Where they are, and how the ball moves, from the simulator.
    #[default]
    Truth,
    /// The ball tracker's estimates from camera and odometry (`eyes`). The goal is known from the start; its error grows with odometry's
    /// drift. The critic is given the ground truth.
    Perceived,
}

/// A robot's estimate of the ball, relative to its base, as its policy is shown it. Odometry's error moves robot and ball alike and is
/// left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BelievedBall {
    /// Center, world `[m]`.
    pub pos: [f64; 3],
    /// Standard deviation of x and of y `[m]`, as the tracker has it.
    pub deviation_m: f64,
    /// Time since the capture of the last image whose detection was accepted `[s]`.
    pub age_s: f64,
    /// True if the true ball is in the camera's image now, near enough to be detected.
    pub in_view: bool,
}

/// Purposes of an environment's random streams: starts of episodes, and two kinds of numbers of a control step.
const START_STREAM: u32 = 5;
const NORMAL_STREAM: u32 = 6;
const CHANCE_STREAM: u32 = 7;

/// The random numbers of an episode's start for the eyes. Episodes of training take theirs from where the stream of resets stands, so that
/// nothing more is to be saved; a start that an evaluation forces looks the same whenever it is forced.
pub(crate) fn start_rng(seed: u64, env: u32, reset_position: Option<u64>) -> Rng {
    let mut rng = Rng::new(seed, env, START_STREAM);
    rng.seek(reset_position.unwrap_or(0) << 10);
    rng
}

/// The ball (seen from the robot) as the robot believes it to be after its first look, with the decay that it reckons with.
///
/// `height_m` is that of the base above the ground, `env` the number of the environment: a start that is forced there
/// ([`crate::EvalControl::force_start`]) begins with the same look, number 0, and a next kick
/// ([`crate::EvalControl::next_kick`]) with the one of its number.
pub fn first_look(
    preset: &EyesPreset,
    ball: &RollingBall,
    height_m: f64,
    seed: u64,
    env: u32,
    look: u64,
) -> RollingBall {
    believed(preset, ball, height_m, &mut start_rng(seed, env, Some(look)))
}

/// As [`first_look`] with given random numbers.
pub(crate) fn believed(preset: &EyesPreset, ball: &RollingBall, height_m: f64, rng: &mut Rng) -> RollingBall {
    let start = BallAtStart { place: ball.place, velocity: ball.velocity, decay: ball.decay, height_m };
    let draw = preset.draw(rng);
    let seen = draw.first_look(preset, &start, rng).belief(&draw.before_start(&start), &preset.tracker).ball;
    RollingBall { place: seen.position, velocity: seen.velocity, decay: draw.decay(&start) }
}

fn pose<V: Real>(body: &BodyState<V>) -> BodyPose<V> {
    BodyPose { pos: body.pos, rot: body.rot }
}

/// A control step of a group's eyes.
pub(crate) struct Look<'a, V> {
    pub config: &'a TaskConfig,
    pub state: &'a GroupState<V>,
    pub eyes: &'a mut Eyes<V>,
    /// Time from this state to the reference's strike `[s]`.
    pub to_strike_s: V,
    /// Environment numbers, one per lane.
    pub envs: &'a [u32],
    pub seed: u64,
    pub count: u64,
}

impl<V: Real> Kernel for Look<'_, V> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let (zero, state) = (V::zero(), self.state);
        let mut numbers = EyesNumbers { normal: [zero; 5], symmetric: [zero; 4] };
        fill_normal(&mut numbers.normal, self.envs, NORMAL_STREAM, self.seed, self.count);
        fill_symmetric(&mut numbers.symmetric, self.envs, CHANCE_STREAM, self.seed, self.count);
        let (base, carrier) = (&state.bodies[0], &state.bodies[self.config.followed[self.config.anchor]]);
        let scene = TrueScene {
            base: pose(base),
            base_vel: base.lin_vel,
            carrier: pose(carrier),
            ball: state.ball.pos,
            ball_vel: state.ball.vel,
        };
        self.eyes.look(&scene, &numbers, self.to_strike_s, &self.config.preset.eyes);
    }
}

/// The estimate of the ball in one lane. `to_strike_s` is the time from the next state to the reference's strike `[s]`.
pub(crate) fn believed_ball<V: Real>(
    eyes: &Eyes<V>,
    config: &TaskConfig,
    state: &GroupState<V>,
    to_strike_s: V,
    lane: usize,
) -> BelievedBall {
    let preset = &config.preset.eyes;
    let (base, carrier) = (&state.bodies[0], &state.bodies[config.followed[config.anchor]]);
    let belief = eyes.belief(to_strike_s + V::c(config.dt_s), preset);
    let BodyPose { pos, rot } = eyes.estimated(&pose(base));
    let in_base = Pose { pos, rot }.point_in_body(eyes.on_the_ground(belief.ball.position));
    let estimate = base.rot.mul_vec(in_base) + base.pos;
    BelievedBall {
        pos: estimate.lane(lane),
        deviation_m: belief.ball.covariance[0].lane(lane).max(0.0).sqrt(),
        age_s: belief.age_s.lane(lane),
        in_view: preset.in_picture(&pose(carrier), state.ball.pos).lane(lane),
    }
}

/// A group's estimate of the scene, and the base's pose by odometry, in which it is shown.
///
/// `goal` is the goal's center in the world `[m]`, as the robot was given it when odometry began; `to_strike_s` and
/// `to_contact_s` the times from this state to the reference's strike and to the foot's contact `[s]`; `predicts` as in
/// [`BelievedScene::view`].
#[inline(always)]
pub(crate) fn seen_scene<V: Real>(
    eyes: &Eyes<V>,
    preset: &EyesPreset,
    base: &BodyState<V>,
    goal: Vec3<V>,
    [to_strike_s, to_contact_s]: [V; 2],
    predicts: bool,
) -> (SceneView<V>, Pose<V>) {
    let ball = eyes.belief(to_strike_s, preset).ball;
    let (velocity, ball) = (ball.velocity, eyes.on_the_ground(ball.position));
    let BodyPose { pos, rot } = eyes.estimated(&pose(base));
    let base = Pose { pos, rot };
    let scene = BelievedScene { ball, velocity, decay: eyes.decay(), goal };
    (scene.view(&base, to_contact_s, predicts), base)
}
