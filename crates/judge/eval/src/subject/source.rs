//! Where a policy comes from: what its file is and what it says about itself.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_onnx::{CONTRACT_KEY, Contract, JointContract, OnnxError, OnnxFile, OnnxPolicy, released_policy};
use paid_play::{ReferenceLibrary, is_onnx, robot_contract};
use paid_policy::observation::ObservationId;
use paid_robot::{Permutation, RobotModel, RobotSpec};
use paid_task::TaskPreset;
use paid_train::TrainedPolicy;

use crate::EvalError;
use crate::policy::{Driver, DriverMaker, Gains, NetworkDriver, OnnxDriver, Twist2};
use crate::scene::ScenePreset;

/// A policy file that has been read.
#[derive(Debug)]
pub enum PolicySource {
    /// A policy file, a checkpoint, or a run folder's policy. It knows its robot, task and motions.
    Network(Box<TrainedPolicy>),
    /// An ONNX file of this project's first format: it has a contract, but names neither task nor motions.
    Onnx(Box<OnnxFile>),
    /// An ONNX file with the interface of PAiD's release.
    Released(Box<OnnxFile>),
    /// The public TWIST2 tracker.
    Twist2(Box<OnnxFile>),
}

impl PolicySource {
    /// Reads a run folder, a checkpoint or an ONNX file.
    ///
    /// # Errors
    /// If the file is missing or damaged.
    pub fn read(path: &Path) -> Result<Self, EvalError> {
        if !is_onnx(path) {
            return Ok(Self::Network(Box::new(TrainedPolicy::load(path)?)));
        }
        let file = Box::new(OnnxFile::read(path)?);
        Ok(if Twist2::fits(&file) {
            Self::Twist2(file)
        } else if let Some(trained) = TrainedPolicy::stored(&file)? {
            Self::Network(Box::new(trained))
        } else if file.metadata(CONTRACT_KEY).is_some() {
            Self::Onnx(file)
        } else {
            Self::Released(file)
        })
    }

    /// The file: of a run folder the checkpoint that was taken.
    pub fn name(&self) -> String {
        match self {
            Self::Network(trained) => trained.checkpoint.display().to_string(),
            Self::Onnx(file) | Self::Released(file) | Self::Twist2(file) => file.path().display().to_string(),
        }
    }

    /// The robot that the policy was trained for; `None` if the file does not say.
    pub fn robot(&self) -> Option<&str> {
        match self {
            Self::Network(trained) => Some(&trained.preset.robot),
            _ => None,
        }
    }

    /// The folder of the motions that it was trained on; empty for the built-in kicks and for a file that does not say.
    ///
    /// # Errors
    /// If the file names a folder that this machine does not have. Other motions would give another score without a word.
    pub fn motions_here(&self) -> Result<PathBuf, EvalError> {
        let Self::Network(trained) = self else { return Ok(PathBuf::new()) };
        let motions = &trained.preset.run.motions;
        if motions.is_empty() || Path::new(motions).exists() {
            return Ok(PathBuf::from(motions));
        }
        Err(EvalError::Motions { policy: trained.checkpoint.clone(), motions: motions.clone() })
    }

    /// The task that it was trained in. For a file that does not say it is the built-in task `fallback`, in which a ball is seen as
    /// the file's observation names it, played as its contract says.
    ///
    /// # Errors
    /// If there is no built-in task `fallback`, or the file's contract is damaged.
    pub fn task(&self, fallback: &str) -> Result<TaskPreset, EvalError> {
        match self {
            Self::Network(trained) => Ok(trained.preset.task.clone()),
            Self::Onnx(file) | Self::Released(file) | Self::Twist2(file) => {
                let mut task = TaskPreset::builtin(fallback)?;
                if let Some(terms) = observed_terms(file) {
                    task.observations.policy = terms;
                }
                if let Self::Onnx(file) = self
                    && let Some(play) = file.contract()?.play
                {
                    task.set_play(play);
                }
                Ok(task)
            }
        }
    }

    /// The constants of MuJoCo's scene that go with it: a peer gets those that it was published with.
    pub fn usual_scene(&self) -> ScenePreset {
        match self {
            Self::Twist2(_) => ScenePreset::Twist2,
            _ => ScenePreset::Paper,
        }
    }

    /// Makes the policy's drivers. Robot and spec get its joint control, if that differs from their own.
    ///
    /// # Errors
    /// If the policy does not fit robot, motions or task.
    pub fn driver(
        self,
        robot: &mut RobotModel,
        spec: &mut RobotSpec,
        library: &Arc<ReferenceLibrary>,
        task: &TaskPreset,
    ) -> Result<Box<DriverMaker<'static>>, EvalError> {
        match self {
            Self::Network(trained) => Ok(Box::new(NetworkDriver::maker(trained.policy))),
            Self::Twist2(file) => {
                Twist2::gains().apply(robot, spec);
                let peer = Twist2::new(*file, Arc::clone(library), robot, spec)?;
                Ok(Box::new(move || Ok(Box::new(peer.clone()) as Box<dyn Driver>)))
            }
            Self::Onnx(file) => {
                let terms = observed_terms(&file).unwrap_or_else(|| task.observations.policy.clone());
                let template = robot_contract(robot, spec, task.control_dt_s(), &terms)?;
                let path = file.path().to_owned();
                let policy = OnnxPolicy::from_file(*file)?;
                let found = policy.contract();
                let expected = Contract { recurrent: found.recurrent, ..template };
                let differences = expected.differences(found);
                if !differences.is_empty() {
                    return Err(OnnxError::ContractDiffers { path, differences }.into());
                }
                onnx_driver(policy, &terms, robot, spec, task)
            }
            Self::Released(file) => {
                let terms = observed_terms(&file).unwrap_or_else(|| task.observations.policy.clone());
                let template = robot_contract(robot, spec, task.control_dt_s(), &terms)?;
                let policy = released_policy(*file, &template)?;
                onnx_driver(policy, &terms, robot, spec, task)
            }
        }
    }
}

/// The terms that a file names, if all of them are this project's.
fn observed_terms(file: &OnnxFile) -> Option<Vec<ObservationId>> {
    file.metadata("observation_names")?.split(',').map(|name| ObservationId::from_name(name.trim())).collect()
}

/// Drivers of an ONNX policy in the task's conventions, after its joint control has been taken over.
fn onnx_driver(
    policy: OnnxPolicy,
    terms: &[ObservationId],
    robot: &mut RobotModel,
    spec: &mut RobotSpec,
    task: &TaskPreset,
) -> Result<Box<DriverMaker<'static>>, EvalError> {
    let gains = gains(policy.contract(), robot)?;
    if !gains.are_of(robot, spec)? {
        gains.apply(robot, spec);
    }
    // The task's action scales follow from its gains.
    let contract = robot_contract(robot, spec, task.control_dt_s(), terms)?;
    let driver = OnnxDriver::new(Arc::new(policy), &contract)?;
    Ok(Box::new(move || Ok(Box::new(driver.clone()) as Box<dyn Driver>)))
}

/// The contract's gains in model order.
fn gains(contract: &Contract, robot: &RobotModel) -> Result<Gains, EvalError> {
    let names: Vec<&str> = contract.joints.iter().map(|j| j.name.as_str()).collect();
    let order = Permutation::between(&names, &robot.joint_names())?;
    let of = |f: fn(&JointContract) -> f64| order.indices().iter().map(|&i| f(&contract.joints[i])).collect();
    Ok(Gains { stiffness: of(|j| j.stiffness), damping: of(|j| j.damping), effort: None })
}
