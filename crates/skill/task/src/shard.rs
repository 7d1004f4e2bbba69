//! A shard: environments that one worker owns.

use std::sync::Arc;

use paid_lanes::{Isa, IsaVisitor, Real};
use paid_physics::{Engine, EngineSpec};
use paid_play::{ReferenceLibrary, body_index};
use paid_policy::{ObservationLayout, VecEnv};
use paid_robot::{RobotModel, RobotSpec};

use crate::{BallCurriculum, EvalControl, SamplerState, Task, TaskError, TaskMetrics, TaskPreset};

/// Environments that report to a trainer and draw their episodes from its sampler. Each `observe` draws new noise;
/// in `step`, `terminated` stands for a failure and `truncated` for the end of the motion or the time limit, never both.
pub trait TrainShard: VecEnv {
    /// Sums and counts since the last call.
    fn take_metrics(&mut self) -> TaskMetrics;
    /// Failures since the last call, `[motion][bin]` flattened: for [`SamplerState::update`].
    fn take_failures(&mut self) -> Vec<f32>;
    /// A fresh (uniform) sampler of this library's size.
    fn new_sampler(&self) -> SamplerState;
    /// From the next reset on, episodes are drawn from these probabilities.
    fn set_sampler(&mut self, sampler: &SamplerState);
    /// From the next reset on, balls are placed by this progress of the curriculum.
    fn set_ball_curriculum(&mut self, curriculum: BallCurriculum);
}

/// Environments of the task that one worker steps together: the trainer's and the evaluator's view.
pub trait TaskShard: TrainShard {
    /// Meaning of the observations.
    fn layout(&self) -> &ObservationLayout;
    /// Control of single environments for evaluation.
    fn eval(&mut self) -> &mut dyn EvalControl;
}

/// What a task is built from.
#[derive(Clone, Copy, Debug)]
pub struct TaskSetup<'a> {
    /// The robot.
    pub robot: &'a RobotModel,
    /// Its control and the names that the task refers to.
    pub spec: &'a RobotSpec,
    /// The reference motions; [`ReferenceLibrary::standing`] for a preset without a reference.
    pub library: &'a Arc<ReferenceLibrary>,
    /// Every constant.
    pub preset: &'a TaskPreset,
    /// Number of the first environment over all shards. An environment's random numbers depend on `seed` and its number only.
    pub first_env: usize,
    /// Seed of everything random.
    pub seed: u64,
}

/// What a shard on the built-in engine is built from.
#[derive(Clone, Copy, Debug)]
pub struct ShardSetup<'a> {
    /// The task.
    pub task: TaskSetup<'a>,
    /// Instruction set, which gives the lane type.
    pub isa: Isa,
    /// Environments; a multiple of the lanes.
    pub num_envs: usize,
}

/// Builds a shard on the built-in engine.
///
/// # Errors
/// If the environments do not fill lane groups, or preset, robot and library do not fit together.
pub fn build_shard(setup: &ShardSetup<'_>) -> Result<Box<dyn TaskShard>, TaskError> {
    setup.task.preset.validate()?;
    let (num_envs, lanes) = (setup.num_envs, setup.isa.lanes());
    if num_envs == 0 || !num_envs.is_multiple_of(lanes) {
        return Err(TaskError::Lanes { num_envs, lanes });
    }
    setup.isa.dispatch(Build { task: &setup.task, groups: num_envs / lanes })
}

/// The built-in engine for a robot and a preset's scene, `groups` lane groups.
///
/// # Errors
/// If robot and scene do not fit the engine.
pub fn build_engine<V: Real>(
    robot: &RobotModel,
    spec: &RobotSpec,
    preset: &TaskPreset,
    groups: usize,
) -> Result<Engine<V>, TaskError> {
    let control = spec.resolve(robot).map_err(|e| TaskError::Robot(e.to_string()))?;
    let feet = [body_index(robot, "foot", &spec.feet[0])?, body_index(robot, "foot", &spec.feet[1])?];
    let engine_spec =
        EngineSpec { feet: feet.to_vec(), stiffness: control.stiffness, damping: control.damping };
    Engine::new(robot, engine_spec, &preset.scene, groups).map_err(|e| TaskError::Simulator(e.to_string()))
}

struct Build<'a> {
    task: &'a TaskSetup<'a>,
    groups: usize,
}

impl IsaVisitor for Build<'_> {
    type Output = Result<Box<dyn TaskShard>, TaskError>;
    fn visit<V: Real<Scalar = f32>>(self) -> Self::Output {
        let TaskSetup { robot, spec, preset, .. } = *self.task;
        let engine = build_engine::<V>(robot, spec, preset, self.groups)?;
        Ok(Box::new(Task::new(engine, self.task)?))
    }
}
