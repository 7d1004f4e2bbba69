//! What is scored: a policy, the task and the motions that it is scored with, and the engine.

mod source;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_lanes::Isa;
use paid_motion::MotionLibrary;
use paid_mujoco::SceneOptions;
use paid_physics::Terrain;
use paid_play::{ReferenceLibrary, load_robot};
use paid_task::TaskPreset;
use paid_task::preset::{KnowledgeMode, ReferenceSource};
use paid_train::Alone;

use crate::engine::EngineChoice;
use crate::episodes::EvalSetup;
use crate::monitor::Monitor;
use crate::policy::DriverMaker;
use crate::scene::{Engines, SceneSpec, check_feet};
use crate::{EvalError, Setting};

pub use source::PolicySource;

/// Plain data that says what is scored. [`Subject::load`] makes it real.
///
/// ```no_run
/// use paid_eval::shooting::{self, ShootingOptions};
/// use paid_eval::subject::{Subject, SubjectSpec};
///
/// let subject = Subject::load(&SubjectSpec::new("policies/demo/policy.onnx"))?;
/// let report = shooting::evaluate(&subject.setup, &*subject.maker, &ShootingOptions::default())?;
/// println!("{}", report.table());
/// # Ok::<(), paid_eval::EvalError>(())
/// ```
#[derive(Clone, Debug)]
pub struct SubjectSpec {
    /// Run folder, checkpoint or ONNX file.
    pub policy: PathBuf,
    /// Built-in robot or robot file; `None`: the policy's own, or the G1 for a file that names none.
    pub robot: Option<String>,
    /// The `mode_machine` of the variant of the robot that is simulated; `None`: the robot as its files have it.
    pub mode_machine: Option<u8>,
    /// Folder of the motion files; `None`: those that the policy was trained on, the built-in kicks if it does not say.
    pub motions: Option<PathBuf>,
    /// Run preset, built in or a file, whose task to score in; `None`: the one that the policy was trained in.
    pub task: Option<String>,
    /// The built-in preset whose task stands in for a policy that does not name its own: `paper_stage1` or `paper_stage2`.
    pub fallback_task: String,
    /// What the policy is given of ball and goal; `None`: as in its task.
    pub knowledge: Option<KnowledgeMode>,
    /// Changed values of the task, each `KEY=VALUE`; they come after `knowledge`.
    pub overrides: Vec<String>,
    /// Which engines score.
    pub engines: Engines,
    /// MuJoCo's scene and the ball of both engines.
    pub scene: SceneSpec,
    /// Lane type of the built-in engine.
    pub isa: Isa,
    /// Worker threads; results do not depend on it.
    pub threads: usize,
    /// Seed of everything random.
    pub seed: u64,
}

impl SubjectSpec {
    /// A policy in the built-in engine, in the task and on the motions that it was trained with, on all cores.
    pub fn new(policy: impl Into<PathBuf>) -> Self {
        Self {
            policy: policy.into(),
            robot: None,
            mode_machine: None,
            motions: None,
            task: None,
            fallback_task: "paper_stage2".to_owned(),
            knowledge: None,
            overrides: Vec::new(),
            engines: Engines::default(),
            scene: SceneSpec::default(),
            isa: Isa::detect(),
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            seed: 0,
        }
    }

    /// The task with the asked changes. It is scored on flat ground, as in the paper's evaluation, also where training was on rough
    /// ground.
    fn task(&self, source: &PolicySource) -> Result<TaskPreset, EvalError> {
        let mut task = match &self.task {
            None => source.task(&self.fallback_task)?,
            Some(name) => paid_train::task_preset(name, &[])?,
        };
        if let Some(knowledge) = self.knowledge {
            task = task.with_knowledge(knowledge);
        }
        task = task.with_overrides(&self.overrides)?;
        if let Some(change) = self.overrides.iter().find(|change| change.starts_with("eyes."))
            && !task.perceives()
        {
            return Err(EvalError::Option {
                option: Setting::Knowledge,
                expected: format!("perceived, for {change}"),
                found: "truth".to_owned(),
            });
        }
        if let Some(change) = self.overrides.iter().find(|change| change.starts_with("scene.terrain")) {
            return Err(EvalError::Option {
                option: Setting::Named("set"),
                expected: "no scene.terrain: --ground is the ground of an evaluation".to_owned(),
                found: change.clone(),
            });
        }
        // Whatever the policy was trained on.
        task.scene.terrain = Terrain::Plane;
        Ok(task)
    }
}

/// A policy and everything that it takes to score it.
pub struct Subject {
    /// Robot, motions, task and engine.
    pub setup: EvalSetup,
    /// Makes the policy's driver for a thread.
    pub maker: Box<DriverMaker<'static>>,
    /// Where the policy came from.
    pub name: String,
    /// What the check says against the motions that fail it; `None` if none does, and for the built-in kicks.
    pub doubts: Option<String>,
    /// Set of each motion: the name of the folder that it lies in.
    pub sets: Vec<String>,
    /// MuJoCo's scene, whichever engine runs first.
    pub scene: SceneOptions,
    /// Which engines score.
    pub engines: Engines,
}

impl Subject {
    /// Reads policy, task and motions, and makes the drivers.
    ///
    /// # Errors
    /// A file that is missing or damaged, parts that do not fit together, or a missing MuJoCo where it is needed.
    pub fn load(spec: &SubjectSpec) -> Result<Self, EvalError> {
        let source = PolicySource::read(&spec.policy)?;
        spec.engines.check()?;
        let name = source.name();
        let mut task = spec.task(&source)?;
        let scene = spec.scene.resolve(&mut task, source.usual_scene())?;
        let (mut robot, mut robot_spec) =
            load_robot(spec.robot.as_deref().or(source.robot()).unwrap_or("g1"))?;
        check_feet(&scene, &robot)?;
        let dt_s = task.control_dt_s();
        let mut doubts = None;
        let (library, sets) = if task.reference == ReferenceSource::None {
            (ReferenceLibrary::standing(&robot, &robot_spec, dt_s)?, vec!["standing".to_owned()])
        } else {
            let folder = match &spec.motions {
                Some(folder) => folder.clone(),
                None => source.motions_here()?,
            };
            let motions = MotionLibrary::open(&folder, &robot, &robot_spec, 1.0 / dt_s)?;
            if !folder.as_os_str().is_empty() {
                doubts = paid_motion::check::doubts(&motions.clips, &robot, &robot_spec)?;
            }
            let library = ReferenceLibrary::for_play(&motions, &robot, &robot_spec, &task.play_preset())?;
            (library, motions.clips.iter().map(|clip| set_of(&clip.path)).collect())
        };
        let library = Arc::new(library);
        let maker = source.driver(&mut robot, &mut robot_spec, &library, &task)?;
        if let Some(mode_machine) = spec.mode_machine {
            (robot, robot_spec) = robot_spec.as_variant(&robot, mode_machine)?;
        }
        let setup = EvalSetup {
            engine: spec.engines.first(&scene),
            isa: spec.isa,
            robot,
            spec: robot_spec,
            library,
            preset: task,
            threads: spec.threads,
            seed: spec.seed,
            monitor: Monitor::default(),
            ranks: Arc::new(Alone),
        };
        Ok(Self { setup, maker, name, doubts, sets, scene, engines: spec.engines })
    }

    /// The setup in MuJoCo.
    pub fn in_mujoco(&self) -> EvalSetup {
        EvalSetup { engine: EngineChoice::Mujoco(Box::new(self.scene.clone())), ..self.setup.clone() }
    }

    /// Refuses a task without a ball.
    ///
    /// # Errors
    /// If the task has none.
    pub fn require_ball(&self) -> Result<(), EvalError> {
        if self.setup.preset.scene.ball {
            return Ok(());
        }
        Err(EvalError::NoBall { task: self.setup.preset.name.clone() })
    }
}

/// The name of the folder that a motion lies in.
fn set_of(path: &Path) -> String {
    path.parent()
        .and_then(Path::file_name)
        .map_or_else(|| "motions".to_owned(), |name| name.to_string_lossy().into_owned())
}
