//! From a preset and a folder of motions to shards of environments.

use std::path::Path;
use std::sync::Arc;

use paid_learn::{Alone, Ranks};
use paid_motion::MotionLibrary;
use paid_play::{ReferenceLibrary, load_robot};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::preset::ReferenceSource;
use paid_task::{ShardSetup, TaskSetup, TaskShard, build_shard};

use crate::policy_weights::load_start;
use crate::{RunPreset, TrainError, TrainedPolicy, Trainer};

/// The clips of a run's motions, whether its task follows them or not.
pub(crate) fn clips_of(
    preset: &RunPreset,
    model: &RobotModel,
    spec: &RobotSpec,
) -> Result<ReferenceLibrary, TrainError> {
    let rate = 1.0 / preset.task.control_dt_s();
    let motions = MotionLibrary::open(Path::new(&preset.run.motions), model, spec, rate)
        .map_err(|e| TrainError::Setup(e.to_string()))?;
    ReferenceLibrary::for_play(&motions, model, spec, &preset.task.play_preset())
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
    /// A policy to imitate ([`Scene::with_teacher`]).
    pub teacher: Option<Arc<TrainedPolicy>>,
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
        Ok(Self { model, spec, library: Arc::new(library), teacher: None })
    }

    /// The preset's robot with motions that are made in memory: generated, or read from a format of one's own. Each clip has the frame
    /// rate of the task's control period.
    ///
    /// # Errors
    /// If the robot cannot be loaded.
    pub fn with_library(preset: &RunPreset, library: ReferenceLibrary) -> Result<Self, TrainError> {
        let (model, spec) = load_robot(&preset.robot)?;
        Ok(Self { model, spec, library: Arc::new(library), teacher: None })
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
        let mut task = preset.task.clone();
        if let Some(teacher) = &self.teacher {
            task.observations.teacher.clone_from(&teacher.preset.task.observations.policy);
        }
        (each * ranks.rank()..each * (ranks.rank() + 1))
            .map(|shard| {
                let task = TaskSetup {
                    robot: &self.model,
                    spec: &self.spec,
                    library: &self.library,
                    preset: &task,
                    first_env: shard * envs,
                    seed: preset.run.seed,
                };
                build_shard(&ShardSetup { task, isa, num_envs: envs })
                    .map_err(|error| TrainError::Setup(error.to_string()))
            })
            .collect()
    }
}

/// Checks that stages can begin one after the other, the first one with the policy `from` if there is one: motions, robot and networks, with
/// the fewest environments that there can be. Nothing is written.
///
/// # Errors
/// The first thing that does not fit; of a file its name.
pub fn check_starts(stages: &[RunPreset], from: Option<&Path>) -> Result<(), TrainError> {
    let mut before: Option<Trainer> = None;
    for preset in stages {
        let fail = |message: String| TrainError::Preset { place: preset.stage.clone(), message };
        let mut few = preset.in_phase(0).map_err(fail)?;
        few.run.shards = 1;
        few.run.envs = few.isa().map_err(TrainError::Setup)?.lanes();
        let scene = Scene::load(&few)?.with_teacher(&few)?;
        let trainer = Trainer::new(&few, scene.shards(&few)?, scene.motion_names())?;
        let mut trainer = scene.equip(&few, trainer)?;
        if let Some(before) = &before {
            let networks = |trainer: &Trainer| {
                let learner = trainer.learner();
                (learner.actor().layout.clone(), learner.critics()[0].layout.clone())
            };
            if networks(before) != networks(&trainer) {
                return Err(fail("expected the networks of the stage before, found others".to_owned()));
            }
        } else if let Some(from) = from {
            let weights = load_start(from, preset)?;
            let found = TrainedPolicy::of(&weights)?.preset.robot;
            if found != preset.robot {
                let message =
                    format!("expected a policy of robot '{}', found one of '{found}'", preset.robot);
                return Err(TrainError::Checkpoint { path: weights.path().to_owned(), message });
            }
            trainer.start_from(&weights)?;
        }
        before = Some(trainer);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    // Slow: makes the built-in kicks for each preset, because the check before a run reads its clips.
    #[test]
    fn stages_begin_with_networks_of_their_own_shape_and_with_clips_of_their_robot() {
        let preset = |name: &str, sets: &[&str]| {
            let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
            RunPreset::resolve(name, &sets).expect(name)
        };
        let stage1 = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/stage1.safetensors");
        // As small as its networks.
        let small = preset("stage2", &["learn.actor.hidden=[1]", "learn.critic.hidden=[1]"]);
        let [one, two] = [preset("stage1", &[]), preset("stage2", &[])];
        check_starts(&[one.clone(), two.clone()], None).expect("the usual two stages");
        check_starts(std::slice::from_ref(&small), Some(&stage1)).expect("a first stage");
        check_starts(&[preset("amp", &[])], None).expect("a style reward");

        let refused = |stages: &[RunPreset], from: Option<&Path>| {
            check_starts(stages, from).expect_err("refused").to_string()
        };
        let error = refused(&[one, preset("stage2", &["learn.actor.hidden=[64]"])], None);
        assert!(error.contains("expected the networks of the stage before"), "{error}");
        let error = refused(
            &[preset("stage2", &["learn.actor.hidden=[1]", "learn.critic.hidden=[2]"])],
            Some(&stage1),
        );
        assert!(error.contains("stage1.safetensors") && error.contains("critic"), "{error}");
        let error = refused(&[two], Some(Path::new(env!("CARGO_MANIFEST_PATH"))));
        assert!(error.contains("Cargo.toml"), "{error}");
        // The clips of a style reward are read too, though no episode follows them.
        let folder = tempfile::tempdir().expect("folder");
        fs::write(folder.path().join("kick.csv"), "# fps: 50\n0,0,1,0,0,0,1,0.5\n0,0,1,0,0,0,1,0.5\n")
            .expect("writes");
        let motions = format!("run.motions={:?}", folder.path().display().to_string());
        let error = refused(&[preset("amp", &[&motions])], None);
        assert!(error.contains("kick.csv"), "{error}");
    }
}
