//! Deterministic episodes for evaluation, without a second implementation of the task.

use serde::{Deserialize, Serialize};

use crate::{BelievedBall, Disturbance, EpisodeRules, Shown, TaskError};

/// How an environment's next episodes begin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InitialState {
    /// Index of the motion in the library.
    pub motion: usize,
    /// Frame of the motion; 0 is its start.
    pub frame: usize,
    /// Ball center (x, y) in the motion's start frame (origin: the anchor's horizontal position at frame 0; x along its
    /// heading, y left) `[m]`; `None`: the motion's nominal place.
    pub ball_xy: Option<[f64; 2]>,
    /// Initial ball velocity in the same axes `[m/s]`.
    pub ball_velocity: [f64; 2],
    /// Goal center (x, y) in the same frame `[m]`; `None`: the center of the preset's rectangle.
    pub goal_xy: Option<[f64; 2]>,
    /// Displacement (x, y) of the robot from the reference in the same axes `[m]`.
    pub displacement: [f64; 2],
    /// True: the preset's reset noise is added.
    pub noise: bool,
}

impl InitialState {
    /// The unperturbed first frame of a motion with ball and goal at their nominal places.
    pub fn nominal(motion: usize) -> Self {
        Self {
            motion,
            frame: 0,
            ball_xy: None,
            ball_velocity: [0.0; 2],
            goal_xy: None,
            displacement: [0.0; 2],
            noise: false,
        }
    }
}

/// The next kick of a robot that continues from where it stands. Axes: origin on the ground below the robot's anchor now, x along the
/// anchor's heading, y left.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NextKick {
    /// Index of the motion in the library; it begins at its first frame.
    pub motion: usize,
    /// Ball center (x, y) `[m]`.
    pub ball_xy: [f64; 2],
    /// Ball velocity `[m/s]`.
    pub ball_velocity: [f64; 2],
    /// Goal center (x, y) `[m]`.
    pub goal_xy: [f64; 2],
    /// Number of the robot's first look at a ball, where knowledge is perceived: equal numbers draw equal errors. An episode begins with 0.
    pub look: u64,
}

/// The first contact of an episode between robot and ball.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct KickEvent {
    /// Control steps since the episode began, the contact's own counted.
    pub step: u32,
    /// The foot nearer to the ball: 0 left, 1 right.
    pub foot: usize,
    /// True if that is the labeled foot.
    pub correct: bool,
    /// Model index of the body that the engine says touched the ball; `None` if it does not say.
    pub body: Option<usize>,
    /// Velocity of that foot's center of mass just after the contact step, world axes `[m/s]`.
    pub foot_vel: [f64; 3],
    /// Ball velocity 5 control steps after the contact, world axes `[m/s]`; `None` before then.
    pub ball_vel_after: Option<[f64; 3]>,
}

/// Pose and velocity of a body, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodySample {
    /// Origin of the body frame `[m]`.
    pub pos: [f64; 3],
    /// Body frame in the world, row-major.
    pub rot: [[f64; 3]; 3],
    /// Velocity of the center of mass `[m/s]`.
    pub com_vel: [f64; 3],
    /// Angular velocity `[rad/s]`.
    pub ang_vel: [f64; 3],
}

/// Everything measurable of one environment after a step.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvSample {
    /// Motion index.
    pub motion: usize,
    /// Frame of the reference that this state was scored against (the state's own frame after a reset). Beyond the
    /// motion's end it stays at the last frame.
    pub frame: usize,
    /// Control steps since the episode began.
    pub step: u32,
    /// True once the reference is past its last frame.
    pub motion_ended: bool,
    /// Bodies, model order.
    pub bodies: Vec<BodySample>,
    /// Joint angles, model order `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Targets of the last control step as the policy gave them, before any delay, model order `[rad]`.
    pub joint_target: Vec<f64>,
    /// Joint velocities, model order `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Actuator torques, model order `[N m]`.
    pub joint_torque: Vec<f64>,
    /// Net contact force on each body, model order, world axes `[N]`.
    pub contact_force: Vec<[f64; 3]>,
    /// Height of the ground below the base `[m]`.
    pub ground_m: f64,
    /// Ball center `[m]`.
    pub ball_pos: [f64; 3],
    /// Ball velocity `[m/s]`.
    pub ball_vel: [f64; 3],
    /// Force of the robot on the ball, world axes `[N]`.
    pub ball_force: [f64; 3],
    /// Goal center `[m]`.
    pub goal_pos: [f64; 3],
    /// Where the reference's anchor is in this frame (x, y), world `[m]`, and its heading `[rad]`.
    pub reference_anchor: ([f64; 2], f64),
    /// Heading of the motion's first frame in the world `[rad]`: the goal plane is perpendicular to it.
    pub heading: f64,
    /// The first kick of the episode.
    pub kick: Option<KickEvent>,
    /// Term x weight x control period of the last step, order of [`crate::reward_names`]; their sum is the step's reward. Empty unless
    /// [`EpisodeRules::reward_terms`] keeps them.
    pub rewards: Vec<f64>,
}

/// Control of single environments. Environments are indexed within their shard.
pub trait EvalControl {
    /// From now on the episodes of the whole shard run by these rules. [`EpisodeRules::TRAINING`] also forgets all forced starts.
    fn set_rules(&mut self, rules: EpisodeRules);
    /// Resets environment `env` to `start` now; later resets of it begin there too, until another start is forced.
    ///
    /// # Errors
    /// If the environment, motion or frame does not exist or a number is not finite.
    fn force_start(&mut self, env: usize, start: &InitialState) -> Result<(), TaskError>;
    /// Environment `env` continues without a reset: the reference of another motion begins where the robot's anchor is, along its
    /// heading, and the ball lies at a new place. The robot's state stays as it is, and so does the count of control steps. Where
    /// knowledge is perceived, the robot has had its first look at the new ball, and knows where the goal is.
    ///
    /// # Errors
    /// If the environment or the motion does not exist, or a number is not finite.
    fn next_kick(&mut self, env: usize, next: &NextKick) -> Result<(), TaskError>;
    /// From now on the policy of environment `env` is shown this ball and goal instead of the simulator's; `None`: as the task says.
    /// The environments of a lane group are shown together: each needs its own.
    ///
    /// # Errors
    /// If the environment does not exist.
    fn show(&mut self, env: usize, shown: Option<&Shown>) -> Result<(), TaskError>;
    /// Disturbs environment `env` from outside between two control steps. Its episode and its reference continue.
    ///
    /// # Errors
    /// If the environment does not exist, or a number is not finite.
    fn disturb(&mut self, env: usize, disturbance: &Disturbance) -> Result<(), TaskError>;
    /// Angular velocity of the ball of environment `env`, world axes `[rad/s]`.
    ///
    /// # Errors
    /// If the environment does not exist.
    fn ball_spin(&self, env: usize) -> Result<[f64; 3], TaskError>;
    /// The estimate of the ball by the robot of environment `env`; `None` where it is given the ground truth or another program's estimate.
    ///
    /// # Errors
    /// If the environment does not exist.
    fn believed_ball(&self, env: usize) -> Result<Option<BelievedBall>, TaskError>;
    /// The state of an environment.
    ///
    /// # Errors
    /// If the environment does not exist.
    fn sample(&self, env: usize) -> Result<EnvSample, TaskError>;
}
