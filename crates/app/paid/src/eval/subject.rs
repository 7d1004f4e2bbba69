//! Arguments that say what is scored.

use std::path::{Path, PathBuf};

use clap::ValueEnum;
use paid_eval::ground::Ground;
use paid_eval::subject::SubjectSpec;
use paid_task::preset::KnowledgeMode;

use super::engine::{EngineArgs, EngineName, positive};
use super::policy_file;
use crate::failure::Failure;
use crate::threads::thread_count;
use crate::train::motion_folder;

/// What all evaluations take.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Policy to score: a run folder, a checkpoint or an ONNX file.
    ///
    /// Of a run folder, the mean of its last checkpoints is taken. An ONNX file may come from this program, have the interface of PAiD's
    /// release, or be the TWIST2 tracker.
    #[arg(long, value_name = "POLICY")]
    pub policy: PathBuf,
    #[command(flatten)]
    pub setting: Setting,
}

impl Common {
    /// What is scored; `fallback_task` is the task of a file that names none.
    pub fn spec(&self, fallback_task: &str) -> Result<SubjectSpec, Failure> {
        self.setting.spec(&self.policy, fallback_task)
    }

    /// [`Common::spec`] of an evaluation that runs in MuJoCo, whatever `--engine` says.
    pub fn spec_of_referee(&self, fallback_task: &str) -> Result<SubjectSpec, Failure> {
        self.setting.spec_in_any_engine(&self.policy, fallback_task)
    }

    /// [`EngineArgs::other_ground`].
    pub fn other_ground(&self) -> Option<Ground> {
        self.setting.scene.other_ground()
    }

    /// [`EngineArgs::set_by_panel`].
    pub fn set_by_panel(&self) -> Option<&'static str> {
        self.setting.scene.set_by_panel()
    }
}

/// The conditions in which a policy is scored or played.
#[derive(Debug, clap::Args)]
pub struct Setting {
    /// Robot that is simulated: built in, or a robot file [default: the policy's, or g1].
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Simulation",
        value_name = "ROBOT",
        requires = "policy"
    )]
    robot: Option<String>,
    /// Variant of the robot, by the mode_machine that it reports: 5, 11, 13, 15 or 18 for a G1 [default: 5].
    #[arg(long, hide_short_help = true, help_heading = "Simulation", value_name = "N", requires = "policy")]
    mode_machine: Option<u8>,
    /// Folder of motion files [default: those the policy was trained on].
    ///
    /// For an ONNX file of another program the default is the built-in kicks.
    #[arg(long, value_name = "DIR", requires = "policy")]
    motions: Option<PathBuf>,
    /// Run preset whose task is used: built in, or a file [default: the policy's].
    ///
    /// For an ONNX file that names no task, the default is paper_stage2 with a ball and paper_stage1 without.
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Simulation",
        value_name = "NAME|FILE",
        requires = "policy"
    )]
    task: Option<String>,
    /// What the policy is given of ball and goal [default: as in its task].
    #[arg(long, value_enum, requires = "policy")]
    knowledge: Option<KnowledgeName>,
    /// With --knowledge perceived: scale of the sensor noise [default: the task's].
    ///
    /// The tracker is not given this scale.
    #[arg(long, hide_short_help = true, help_heading = "Simulation", value_name = "FACTOR", value_parser = positive, requires = "policy")]
    eyes_noise: Option<f64>,
    /// With --knowledge perceived: age of an image on arrival [ms] [default: the task's].
    #[arg(long, hide_short_help = true, help_heading = "Simulation", value_name = "MS", value_parser = latency, requires = "policy")]
    eyes_latency_ms: Option<f64>,
    /// Change a task value, such as scene.ground.restitution=0 (repeatable).
    #[arg(long = "set", help_heading = "Simulation", value_name = "KEY=VALUE", requires = "policy")]
    sets: Vec<String>,
    /// Seed of all random numbers.
    #[arg(long, help_heading = "Simulation", default_value_t = 0, requires = "policy")]
    seed: u64,
    /// Worker threads; the result does not depend on them [default: all cores].
    #[arg(long, hide_short_help = true, help_heading = "Simulation", value_name = "N", requires = "policy")]
    threads: Option<usize>,
    /// Instruction set: auto, avx512, avx2 or portable. Each rounds differently.
    #[arg(
        long,
        hide_short_help = true,
        help_heading = "Simulation",
        default_value = "auto",
        requires = "policy"
    )]
    isa: String,
    /// Engine that simulates.
    #[arg(long, value_enum, default_value = "builtin", requires = "policy")]
    engine: EngineName,
    #[command(flatten)]
    scene: EngineArgs,
}

/// Longest age of an image [ms], as in a task.
const MOST_LATENCY_MS: f64 = 500.0;

fn latency(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|ms| (0.0..=MOST_LATENCY_MS).contains(ms));
    found.ok_or_else(|| format!("expected 0 to {MOST_LATENCY_MS} ms, found '{text}'"))
}

/// What the policy is given of ball and goal.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum KnowledgeName {
    /// Exact positions, and the velocity of the ball, from the simulator.
    Truth,
    /// What camera, odometry and ball tracker estimate.
    Perceived,
}

impl From<KnowledgeName> for KnowledgeMode {
    fn from(name: KnowledgeName) -> Self {
        match name {
            KnowledgeName::Truth => Self::Truth,
            KnowledgeName::Perceived => Self::Perceived,
        }
    }
}

impl Setting {
    /// Changes of the task's values: the eyes', then those of `--set`.
    fn overrides(&self) -> Vec<String> {
        let noise = self.eyes_noise.map(|factor| format!("eyes.noise_scale=[{factor:?}, {factor:?}]"));
        let latency = self.eyes_latency_ms.map(|ms| 1e-3 * ms);
        let latency = latency.map(|s| format!("eyes.latency_s=[{s:?}, {s:?}]"));
        noise.into_iter().chain(latency).chain(self.sets.iter().cloned()).collect()
    }

    /// Refuses `--engine both` where a single episode is played, before anything is read.
    pub fn one_engine(&self) -> Result<(), Failure> {
        match self.engine {
            EngineName::Builtin | EngineName::Mujoco => Ok(()),
            EngineName::Both => {
                Err(Failure::input("--engine: expected builtin or mujoco for one episode, found both"))
            }
        }
    }

    /// What is scored, with the policy apart from its conditions.
    pub fn spec(&self, policy: &Path, fallback_task: &str) -> Result<SubjectSpec, Failure> {
        if let Some(ground) = self.scene.other_ground().filter(|_| self.engine != EngineName::Mujoco) {
            let engine = if self.engine == EngineName::Both { "both" } else { "builtin" };
            return Err(Failure::input(format!(
                "--ground {}: expected --engine mujoco, which alone has it, found {engine}",
                ground.name()
            )));
        }
        if let Some(key) = self.scene.only_in_mujoco().filter(|_| self.engine == EngineName::Builtin) {
            return Err(Failure::input(format!(
                "--scene: {key}: expected --engine mujoco or both, whose scene it changes, found builtin"
            )));
        }
        self.spec_in_any_engine(policy, fallback_task)
    }

    fn spec_in_any_engine(&self, policy: &Path, fallback_task: &str) -> Result<SubjectSpec, Failure> {
        policy_file::check(policy)?;
        self.motions.as_deref().map_or(Ok(()), motion_folder)?;
        Ok(SubjectSpec {
            robot: self.robot.clone(),
            mode_machine: self.mode_machine,
            motions: self.motions.clone(),
            task: self.task.clone(),
            fallback_task: fallback_task.to_owned(),
            knowledge: self.knowledge.map(Into::into),
            overrides: self.overrides(),
            engines: self.engine.into(),
            scene: self.scene.spec(),
            isa: self.isa.parse().map_err(Failure::input)?,
            threads: thread_count(self.threads)?,
            seed: self.seed,
            ..SubjectSpec::new(policy)
        })
    }
}
