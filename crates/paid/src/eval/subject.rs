//! The policy to score and the task to score it in.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_eval::engine::Engine;
use paid_eval::episodes::EvalSetup;
use paid_eval::monitor::Monitor;
use paid_eval::policy::{Gains, LearnedPolicy, OnnxDriver, Policy, PolicyMaker, Twist2};
use paid_motion::MotionLibrary;
use paid_mujoco::{Library, SceneOptions};
use paid_onnx::{CONTRACT_KEY, Contract, JointContract, OnnxError, OnnxFile, OnnxPolicy, released_policy};
use paid_physics::Terrain;
use paid_policy::observation::ObservationId;
use paid_robot::{Permutation, RobotModel, RobotSpec};
use paid_task::{ReferenceLibrary, TaskPreset};
use paid_train::TrainedPolicy;
use paid_train::policy_file::task_contract;
use paid_train::setup::load_robot;

use super::engine::{EngineArgs, EngineName, Protocol, check_feet, engine_of};
use crate::failure::Failure;
use crate::train::thread_count;

/// What all evaluations take.
#[derive(Debug, clap::Args)]
pub struct Common {
    /// Run folder (the mean of its last checkpoints), checkpoint file, or ONNX file: this project's, one with PAiD's released interface, or
    /// the TWIST2 tracker.
    #[arg(long, value_name = "RUN|CHECKPOINT|ONNX")]
    policy: PathBuf,
    #[command(flatten)]
    pub setting: Setting,
}

/// In what a policy is scored or played.
#[derive(Debug, clap::Args)]
pub struct Setting {
    /// Built-in robot or robot file, for ONNX files.
    #[arg(long, default_value = "g1")]
    robot: String,
    /// Folder of the motion files [default: those that the policy was trained on; for an ONNX file the built-in kicks].
    #[arg(long, value_name = "DIR", requires = "policy")]
    motions: Option<PathBuf>,
    /// Built-in task or task preset file to score in [default: the one the policy was trained in; for an ONNX file stage2 with
    /// a ball, stage1 without].
    #[arg(long, value_name = "NAME|FILE", requires = "policy")]
    task: Option<String>,
    /// Change a value of the task, such as scene.ground.restitution=0 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "policy")]
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
    #[arg(long, value_enum, default_value = "builtin", requires = "policy")]
    pub engine: EngineName,
    #[command(flatten)]
    scene: EngineArgs,
}

impl Setting {
    /// Refuses `--engine both` where a single episode is played, before anything is read.
    pub fn one_engine(&self) -> Result<(), Failure> {
        match self.engine {
            EngineName::Builtin | EngineName::Mujoco => Ok(()),
            EngineName::Both => {
                Err(Failure::input("--engine: expected builtin or mujoco for one episode, found both"))
            }
        }
    }
}

impl Common {
    /// A policy on the built-in engine, everything else as usual.
    pub fn usual(policy: PathBuf, motions: Option<PathBuf>, seed: u64, threads: Option<usize>) -> Self {
        let setting = Setting {
            robot: "g1".to_owned(),
            motions,
            task: None,
            sets: Vec::new(),
            seed,
            threads,
            isa: "auto".to_owned(),
            engine: EngineName::Builtin,
            scene: EngineArgs::default(),
        };
        Self { policy, setting }
    }
}

/// A policy and the task to score it in.
pub struct Subject {
    /// Robot, motions, task and engine.
    pub setup: EvalSetup,
    /// Makes the policy for a thread.
    pub maker: Box<PolicyMaker<'static>>,
    /// Where the policy came from.
    pub name: String,
    /// Set of each motion: the name of the folder that it lies in.
    pub sets: Vec<String>,
    /// MuJoCo's scene.
    pub scene: SceneOptions,
}

/// What a policy file says about itself.
struct Source {
    /// Where it came from.
    name: String,
    robot: String,
    /// The task that it was trained in.
    task: TaskPreset,
    /// Its motions; empty for the built-in kicks.
    motions: PathBuf,
    kind: Kind,
}

/// Kinds of policies.
enum Kind {
    Network(Box<paid_learn::Policy>),
    Onnx(Box<OnnxFile>),
}

impl Source {
    fn load(policy: &Path, robot: &str, usual_task: &str) -> Result<Self, Failure> {
        if policy.extension().is_some_and(|e| e.eq_ignore_ascii_case("onnx")) {
            let file = OnnxFile::read(policy).map_err(Failure::input)?;
            let mut task = TaskPreset::builtin(usual_task).map_err(Failure::input)?;
            if let Some(terms) = observed_terms(&file) {
                task.observations.policy = terms;
            }
            return Ok(Self {
                name: policy.display().to_string(),
                robot: robot.to_owned(),
                task,
                motions: PathBuf::new(),
                kind: Kind::Onnx(Box::new(file)),
            });
        }
        let TrainedPolicy { checkpoint, preset, policy, .. } =
            TrainedPolicy::load(policy).map_err(Failure::input)?;
        Ok(Self {
            name: checkpoint.display().to_string(),
            robot: preset.robot,
            task: preset.task,
            motions: PathBuf::from(preset.run.motions),
            kind: Kind::Network(Box::new(policy)),
        })
    }

    /// The constants of MuJoCo's scene if nobody asks for others: a peer gets those that it is published with.
    fn usual_protocol(&self) -> Protocol {
        match &self.kind {
            Kind::Onnx(file) if Twist2::fits(file) => Protocol::Twist2,
            _ => Protocol::Paper,
        }
    }
}

impl Subject {
    /// Reads policy, motions and task; `usual_task` is that of a file that names none.
    pub fn load(common: &Common, usual_task: &str) -> Result<Self, Failure> {
        Self::load_in(&common.policy, &common.setting, usual_task)
    }

    /// As [`Subject::load`], with the policy apart from where it is to be seen.
    pub fn load_in(policy: &Path, setting: &Setting, usual_task: &str) -> Result<Self, Failure> {
        let source = Source::load(policy, &setting.robot, usual_task)?;
        Self::needs_mujoco(setting.engine)?;
        let usual = source.usual_protocol();
        let mut task = task_preset(setting, source.task)?;
        // Scored on flat ground, as in the paper's evaluation, also where training was on rough ground.
        task.scene.terrain = Terrain::Plane;
        let scene = setting.scene.scene(&mut task, usual)?;
        let (mut robot, mut spec) = load_robot(&source.robot).map_err(Failure::input)?;
        check_feet(&scene, &robot)?;
        let folder = setting.motions.clone().unwrap_or(source.motions);
        let motions =
            MotionLibrary::open(&folder, &robot, &spec, 1.0 / task.control_dt_s()).map_err(Failure::input)?;
        let sets = motions.clips.iter().map(|clip| set_of(&clip.path)).collect();
        let library =
            Arc::new(ReferenceLibrary::from_motions(&motions, &robot, &spec).map_err(Failure::input)?);
        let maker: Box<PolicyMaker<'static>> = match source.kind {
            Kind::Network(policy) => Box::new(LearnedPolicy::maker(*policy)),
            Kind::Onnx(file) if Twist2::fits(&file) => {
                Twist2::gains().apply(&mut robot, &mut spec);
                let peer = Twist2::new(*file, Arc::clone(&library), &robot, &spec).map_err(Failure::input)?;
                Box::new(move || Ok(Box::new(peer.clone()) as Box<dyn Policy>))
            }
            Kind::Onnx(file) => onnx(*file, &mut robot, &mut spec, &task)?,
        };
        let setup = EvalSetup {
            engine: engine_of(setting.engine, &scene),
            isa: setting.isa.parse().map_err(Failure::input)?,
            robot,
            spec,
            library,
            preset: task,
            threads: thread_count(setting.threads)?,
            seed: setting.seed,
            monitor: Monitor::default(),
        };
        Ok(Self { setup, maker, name: source.name, sets, scene })
    }

    /// The engine of a name with this subject's scene.
    pub fn engine(&self, name: EngineName) -> Engine {
        engine_of(name, &self.scene)
    }

    /// Says that MuJoCo is missing before anything else has run in vain.
    pub fn needs_mujoco(engine: EngineName) -> Result<(), Failure> {
        if engine != EngineName::Builtin {
            Library::get().map_err(Failure::input)?;
        }
        Ok(())
    }

    /// Refuses a task without a ball.
    pub fn needs_ball(&self) -> Result<(), Failure> {
        if self.setup.preset.scene.ball {
            return Ok(());
        }
        Err(Failure::input(format!(
            "task '{}': expected one with a physical ball, found scene.ball = false; score in another with --task stage2",
            self.setup.preset.name
        )))
    }
}

/// The terms that the file says it observes, if this project knows them all.
fn observed_terms(file: &OnnxFile) -> Option<Vec<ObservationId>> {
    file.metadata("observation_names")?.split(',').map(|name| ObservationId::from_name(name.trim())).collect()
}

/// An ONNX file with this project's contract, or with the released interface; robot and spec get its gains if they are others.
fn onnx(
    file: OnnxFile,
    robot: &mut RobotModel,
    spec: &mut RobotSpec,
    task: &TaskPreset,
) -> Result<Box<PolicyMaker<'static>>, Failure> {
    let path = file.path().to_owned();
    let terms = observed_terms(&file).unwrap_or_else(|| task.observations.policy.clone());
    let dt_s = task.control_dt_s();
    let template = task_contract(robot, spec, dt_s, &terms).map_err(Failure::input)?;
    let policy = if file.metadata(CONTRACT_KEY).is_some() {
        let policy = OnnxPolicy::from_file(file).map_err(Failure::input)?;
        let found = policy.contract();
        let expected = Contract { recurrent: found.recurrent, ..template };
        let differences = expected.differences(found);
        if !differences.is_empty() {
            return Err(Failure::input(OnnxError::ContractDiffers { path, differences }));
        }
        policy
    } else {
        released_policy(file, &template).map_err(Failure::input)?
    };
    let gains = gains(policy.contract(), robot)?;
    if !gains.are_of(robot, spec).map_err(Failure::input)? {
        gains.apply(robot, spec);
    }
    // The task's action scales follow from its gains.
    let task = task_contract(robot, spec, dt_s, &terms).map_err(Failure::input)?;
    let driver = OnnxDriver::new(Arc::new(policy), &task).map_err(Failure::input)?;
    Ok(Box::new(move || Ok(Box::new(driver.clone()) as Box<dyn Policy>)))
}

/// The contract's gains in model order.
fn gains(contract: &Contract, robot: &RobotModel) -> Result<Gains, Failure> {
    let names: Vec<&str> = contract.joints.iter().map(|j| j.name.as_str()).collect();
    let order = Permutation::between(&names, &robot.joint_names()).map_err(Failure::input)?;
    let of = |f: fn(&JointContract) -> f64| order.indices().iter().map(|&i| f(&contract.joints[i])).collect();
    Ok(Gains { stiffness: of(|j| j.stiffness), damping: of(|j| j.damping), effort: None })
}

fn task_preset(setting: &Setting, trained: TaskPreset) -> Result<TaskPreset, Failure> {
    let (name, text) = match &setting.task {
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
    TaskPreset::parse(&name, &text, &setting.sets).map_err(Failure::input)
}

/// The name of the folder that a motion lies in.
fn set_of(path: &Path) -> String {
    path.parent()
        .and_then(Path::file_name)
        .map_or_else(|| "motions".to_owned(), |name| name.to_string_lossy().into_owned())
}
