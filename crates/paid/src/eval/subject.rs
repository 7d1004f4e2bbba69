//! The policy to score and the task to score it in.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_eval::engine::Engine;
use paid_eval::episodes::Arena;
use paid_eval::monitor::Monitor;
use paid_eval::policy::{LearnedPolicy, PolicyMaker};
use paid_learn::Checkpoint;
use paid_motion::MotionLibrary;
use paid_mujoco::SceneOptions;
use paid_physics::Terrain;
use paid_task::{ReferenceLibrary, TaskPreset};
use paid_train::RunPreset;
use paid_train::folder::{PRESET_FILE, latest_checkpoint};
use paid_train::setup::load_robot;

use super::engine::{EngineArgs, EngineName, engine_of};
use crate::failure::Failure;
use crate::train::thread_count;

/// What all evaluations take.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Run folder (its newest checkpoint) or checkpoint file.
    #[arg(long, value_name = "RUN|CHECKPOINT")]
    policy: PathBuf,
    /// Folder of the motion files [default: the one the policy was trained on].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Built-in task or task preset file to score in [default: the one the policy was trained in].
    #[arg(long, value_name = "NAME|FILE")]
    task: Option<String>,
    /// Change a value of the task, such as scene.ground.restitution=0 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Seed of everything random.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Worker threads; the result does not depend on it [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Instruction set: auto, avx512, avx2 or portable. Two sets round differently.
    #[arg(long, default_value = "auto")]
    isa: String,
    /// Who simulates.
    #[arg(long, value_enum, default_value = "builtin")]
    pub engine: EngineName,
    #[command(flatten)]
    scene: EngineArgs,
}

/// A policy and the task to score it in.
pub struct Subject {
    /// Robot, motions, task and engine.
    pub arena: Arena,
    /// Makes the policy for a thread.
    pub maker: Box<PolicyMaker<'static>>,
    /// Where the policy came from.
    pub name: String,
    /// Set of each motion: the name of the folder that it lies in.
    pub sets: Vec<String>,
    /// MuJoCo's scene.
    pub scene: SceneOptions,
}

impl Subject {
    /// Reads policy, motions and task.
    pub fn load(common: &Common) -> Result<Self, Failure> {
        let path = if common.policy.is_dir() {
            latest_checkpoint(&common.policy).map_err(Failure::input)?
        } else {
            common.policy.clone()
        };
        let checkpoint = Checkpoint::load(&path).map_err(Failure::input)?;
        let text =
            checkpoint.blob(PRESET_FILE).and_then(|b| std::str::from_utf8(b).ok()).ok_or_else(|| {
                Failure::input(format!(
                    "{}: expected an entry '{PRESET_FILE}' (text), found none",
                    path.display()
                ))
            })?;
        let run = RunPreset::from_resolved(&path.to_string_lossy(), text, &[]).map_err(Failure::input)?;
        let mut task = task_preset(common, run.task)?;
        // Scored on flat ground, as in the paper's evaluation, also where training was on rough ground.
        task.scene.terrain = Terrain::Plane;
        let scene = common.scene.scene(&mut task);
        let (robot, spec) = load_robot(&run.robot).map_err(Failure::input)?;
        let folder = match &common.motions {
            Some(folder) => folder.clone(),
            None if run.run.motions.is_empty() => {
                return Err(Failure::input(format!(
                    "{}: names no motions; say which with --motions DIR",
                    path.display()
                )));
            }
            None => PathBuf::from(&run.run.motions),
        };
        let motions =
            MotionLibrary::load(&folder, &robot, &spec, 1.0 / task.control_dt_s()).map_err(Failure::input)?;
        let sets = motions.clips.iter().map(|clip| set_of(&clip.path)).collect();
        let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).map_err(Failure::input)?;
        let policy = checkpoint.policy().map_err(Failure::input)?;
        let arena = Arena {
            engine: engine_of(common.engine, &scene),
            isa: common.isa.parse().map_err(Failure::input)?,
            robot,
            spec,
            library: Arc::new(library),
            preset: task,
            threads: thread_count(common.threads)?,
            seed: common.seed,
            monitor: Monitor::default(),
        };
        let name = path.display().to_string();
        Ok(Self { arena, maker: Box::new(LearnedPolicy::maker(policy)), name, sets, scene })
    }

    /// The engine of a name with this subject's scene.
    pub fn engine(&self, name: EngineName) -> Engine {
        engine_of(name, &self.scene)
    }

    /// Refuses a task without a ball.
    pub fn needs_ball(&self) -> Result<(), Failure> {
        if self.arena.preset.scene.ball {
            return Ok(());
        }
        Err(Failure::input(format!(
            "task '{}': expected one with a physical ball, found scene.ball = false; score in another with --task stage2",
            self.arena.preset.name
        )))
    }
}

fn task_preset(common: &Common, trained: TaskPreset) -> Result<TaskPreset, Failure> {
    let (name, text) = match &common.task {
        None => (trained.name.clone(), toml::to_string(&trained).map_err(Failure::input)?),
        Some(file) if file.ends_with(".toml") => {
            let text = std::fs::read_to_string(file).map_err(|e| Failure::input(format!("{file}: {e}")))?;
            (file.clone(), text)
        }
        Some(name) => {
            let preset = TaskPreset::builtin(name).map_err(Failure::input)?;
            (name.clone(), toml::to_string(&preset).map_err(Failure::input)?)
        }
    };
    TaskPreset::parse(&name, &text, &common.sets).map_err(Failure::input)
}

/// The name of the folder that a motion lies in.
fn set_of(path: &Path) -> String {
    path.parent()
        .and_then(Path::file_name)
        .map_or_else(|| "motions".to_owned(), |name| name.to_string_lossy().into_owned())
}
