//! From a preset and a folder of motions to shards of environments.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use paid_learn::{Alone, Ranks};
use paid_motion::MotionLibrary;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::preset::ReferenceSource;
use paid_task::{ReferenceLibrary, ShardSetup, TaskSetup, TaskShard, build_shard};

use crate::{RunPreset, TrainError};

/// A robot by name (`g1` is built in) or by the path of its TOML, whose MJCF lies beside it under the same name.
///
/// # Errors
/// File, line, expected and found.
pub fn load_robot(robot: &str) -> Result<(RobotModel, RobotSpec), TrainError> {
    if robot == "g1" {
        return Ok((RobotModel::g1(), RobotSpec::g1()));
    }
    let toml = Path::new(robot);
    if toml.extension().is_none_or(|e| e != "toml") {
        return Err(TrainError::Setup(format!(
            "robot: expected 'g1' or the path of a .toml file, found '{robot}'"
        )));
    }
    let mjcf = toml.with_extension("xml");
    let text = |path: &Path| fs::read_to_string(path).map_err(TrainError::read(path));
    let spec = RobotSpec::from_toml(&text(toml)?, robot).map_err(|e| TrainError::Setup(e.to_string()))?;
    let model = RobotModel::from_mjcf(&text(&mjcf)?, &mjcf.to_string_lossy())
        .map_err(|e| TrainError::Setup(e.to_string()))?;
    Ok((model, spec))
}

/// The clips of a run's motions, whether its task follows them or not.
pub(crate) fn clips_of(
    preset: &RunPreset,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<ReferenceLibrary, TrainError> {
    let rate = 1.0 / preset.task.control_dt_s();
    let motions = MotionLibrary::open(Path::new(&preset.run.motions), model, spec, rate)
        .map_err(|e| TrainError::Setup(e.to_string()))?;
    ReferenceLibrary::for_task(&motions, model, spec, &preset.task)
        .map_err(|e| TrainError::Setup(e.to_string()))
}

/// The robot and the motions of a run.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Tree, masses, contact shapes.
    pub model: RobotModel,
    /// Gains and names.
    pub spec: RobotSpec,
    /// The motions in the task's form.
    pub library: Arc<ReferenceLibrary>,
}

impl Scene {
    /// Loads what the preset names.
    ///
    /// # Errors
    /// One sentence naming file, place, expected and found.
    pub fn load(preset: &RunPreset) -> Result<Self, TrainError> {
        let (model, spec) = load_robot(&preset.robot)?;
        let library = match preset.task.reference {
            ReferenceSource::Motions => clips_of(preset, &model, &spec)?,
            ReferenceSource::None => ReferenceLibrary::standing(&model, &spec, preset.task.control_dt_s())
                .map_err(|e| TrainError::Setup(e.to_string()))?,
        };
        Ok(Self { model, spec, library: Arc::new(library) })
    }

    /// Names of the motions in order.
    pub fn motion_names(&self) -> Vec<String> {
        self.library.facts().iter().map(|fact| fact.name.clone()).collect()
    }

    /// The shards of a run: equal in size, environments numbered through.
    ///
    /// # Errors
    /// If preset, robot and motions do not fit together.
    pub fn shards(&self, preset: &RunPreset) -> Result<Vec<Box<dyn TaskShard>>, TrainError> {
        self.shards_of(preset, &Alone)
    }

    /// This rank's part of the shards of a run: as many as every other rank's.
    ///
    /// # Errors
    /// As [`Scene::shards`], or if the ranks cannot share the shards evenly.
    pub fn shards_of(
        &self,
        preset: &RunPreset,
        ranks: &dyn Ranks,
    ) -> Result<Vec<Box<dyn TaskShard>>, TrainError> {
        let (shards, count) = (preset.run.shards, ranks.count());
        if !shards.is_multiple_of(count) {
            return Err(TrainError::Setup(format!(
                "run.shards: expected a multiple of {count}, the number of ranks, found {shards}"
            )));
        }
        let each = shards / count;
        let isa = preset.isa().map_err(TrainError::Setup)?;
        let envs = preset.run.envs / preset.run.shards;
        (each * ranks.rank()..each * (ranks.rank() + 1))
            .map(|shard| {
                let task = TaskSetup {
                    robot: &self.model,
                    spec: &self.spec,
                    library: &self.library,
                    preset: &preset.task,
                    first_env: shard * envs,
                    seed: preset.run.seed,
                };
                build_shard(&ShardSetup { task, isa, num_envs: envs })
                    .map_err(|error| TrainError::Setup(error.to_string()))
            })
            .collect()
    }
}
