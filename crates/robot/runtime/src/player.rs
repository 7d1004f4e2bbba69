//! What is played: a policy with its motions, on the robot that it was trained for.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use paid_lanes::{Mat3, Quat, Vec3};
use paid_motion::MotionLibrary;
use paid_play::{PlayPreset, PolicyFile, ReferenceLibrary, robot_contract};
use paid_policy::observation::{self, Need};
use paid_policy::{Mirrors, Policy, Pose, ReferenceView};
use paid_robot::{ControlSpec, Permutation, RobotModel, RobotSpec};
use serde::{Deserialize, Serialize};

use crate::DeployError;
use crate::machine::MODE_MACHINE_G1;
use crate::motors::motors_of;

/// Where a player comes from.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PlayerSpec {
    /// The policy: a checkpoint.
    pub policy: PathBuf,
    /// Folder of the motion files; `None`: those that the policy was trained on.
    pub motions: Option<PathBuf>,
    /// Changed values of how it is played, each `KEY=VALUE`.
    pub sets: Vec<String>,
}

/// A policy, its motions and its robot.
#[derive(Clone, Debug)]
pub struct Player {
    /// Which G1 it is for, see [`Player::as_variant`].
    pub mode_machine: u8,
    /// Tree and limits: the G1's, whatever robot file the policy was trained with.
    pub model: RobotModel,
    /// Names and gains, the G1's too.
    pub spec: RobotSpec,
    /// Gains, default pose, action scales, model order.
    pub control: ControlSpec,
    /// The policy's file.
    pub path: PathBuf,
    /// How the policy is played.
    pub play: PlayPreset,
    /// What was changed of that, each `KEY=VALUE`.
    pub sets: Vec<String>,
    /// The motions.
    pub library: Arc<ReferenceLibrary>,
    /// The network.
    pub policy: Arc<Policy>,
    /// Model joint of each policy joint.
    pub to_model: Vec<usize>,
    /// Motor of each model joint.
    pub motors: Vec<usize>,
    /// Tree and spec of the robot's files, which the variants differ from.
    files: Arc<(RobotModel, RobotSpec)>,
    /// How observation and action of a left-footed kick read in a mirror, if that is how the policy plays it.
    mirrors: Option<Mirrors>,
    /// Place of the anchor among the library's followed bodies.
    anchor: usize,
    /// Joints (model order) from the base to the anchor.
    waist: Vec<usize>,
}

impl Player {
    /// Reads policy and motions.
    ///
    /// # Errors
    /// If a file is missing or damaged, the policy is for another robot than the G1, it was trained without a ball, or it observes
    /// what only a simulator knows.
    pub fn load(spec: &PlayerSpec) -> Result<Self, DeployError> {
        let file = PolicyFile::load(&spec.policy, &spec.sets).map_err(DeployError::policy)?;
        if !file.play.scene.ball {
            return Err(DeployError::Policy(format!(
                "{}: expected a policy of a task with a ball (Stage II), found the task '{}' without one",
                file.path.display(),
                file.play.name
            )));
        }
        let own = &file.motions;
        let folder = match &spec.motions {
            Some(folder) => folder.clone(),
            None if own.is_empty() || Path::new(own).exists() => PathBuf::from(own),
            None => {
                return Err(DeployError::Policy(format!(
                    "{}: trained on the motions of '{own}', which are not here: name their folder",
                    file.path.display()
                )));
            }
        };
        let rate = 1.0 / file.play.control_dt_s();
        let motions =
            MotionLibrary::open(&folder, &file.model, &file.spec, rate).map_err(DeployError::policy)?;
        let library = ReferenceLibrary::for_play(&motions, &file.model, &file.spec, &file.play)
            .map_err(DeployError::policy)?;
        Self::new(file, library)
    }

    /// Puts the parts together.
    ///
    /// # Errors
    /// As [`Player::load`].
    pub fn new(file: PolicyFile, library: impl Into<Arc<ReferenceLibrary>>) -> Result<Self, DeployError> {
        let contract = file.contract("").map_err(DeployError::policy)?;
        let PolicyFile { path, play, sets, model: theirs, policy, .. } = file;
        let library = library.into();
        let terms = &play.observations.policy;
        // The robot as this program knows it, not as the policy's file has it: a robot file of the policy's own may have the same gains,
        // and ranges, speeds and torques that limit nothing.
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let robot = robot_contract(&model, &spec, 0.02, terms).map_err(DeployError::policy)?;
        let robot = paid_policy::Contract { recurrent: contract.recurrent, ..robot };
        let mut differences = robot.differences(&contract);
        // The motions are in the order of that file.
        differences.extend(first_difference("joint", &model.joint_names(), &theirs.joint_names()));
        differences.extend(first_difference("body", &model.body_names(), &theirs.body_names()));
        if !differences.is_empty() {
            return Err(DeployError::Policy(format!(
                "{}: the policy is not for this robot: {}",
                path.display(),
                differences.join("; ")
            )));
        }
        observation::check(terms, &[Need::Reference, Need::Scene]).map_err(DeployError::policy)?;
        let control = spec.resolve(&model).map_err(DeployError::policy)?;
        let to_model = Permutation::between(&model.joint_names(), &spec.policy_joint_order)
            .map_err(DeployError::policy)?
            .indices()
            .to_vec();
        let motors = motors_of(&model.joint_names()).map_err(DeployError::policy)?;
        let anchor_body = model
            .body_index(&spec.anchor_body)
            .ok_or_else(|| DeployError::Policy(format!("the robot has no body '{}'", spec.anchor_body)))?;
        let anchor = library.followed().iter().position(|&b| b == anchor_body).unwrap_or(0);
        let waist = chain(&model, anchor_body);
        let mirrors = if play.mirror_left_kicks {
            Some(paid_play::policy_mirrors(&model, &spec, terms).map_err(DeployError::policy)?)
        } else {
            None
        };
        Ok(Self {
            path,
            mode_machine: MODE_MACHINE_G1,
            files: Arc::new((model.clone(), spec.clone())),
            model,
            spec,
            control,
            play,
            sets,
            library,
            policy: Arc::new(policy),
            to_model,
            motors,
            mirrors,
            anchor,
            waist,
        })
    }

    /// The player of the G1 that reports `mode_machine`, with that robot's limits and gains.
    ///
    /// # Errors
    /// If the program does not know such a robot.
    pub fn as_variant(&self, mode_machine: u8) -> Result<Self, DeployError> {
        let (model, spec) = &*self.files;
        let (model, spec) = spec.as_variant(model, mode_machine).map_err(DeployError::policy)?;
        let control = spec.resolve(&model).map_err(DeployError::policy)?;
        Ok(Self { mode_machine, model, spec, control, ..self.clone() })
    }

    /// True if the policy was trained on this G1.
    pub fn is_trained(&self) -> bool {
        let trained = &self.play.randomization.mode_machines;
        if trained.is_empty() {
            self.mode_machine == MODE_MACHINE_G1
        } else {
            trained.contains(&self.mode_machine)
        }
    }

    /// How a motion's observations and actions read in a mirror, if it is played in one.
    pub fn mirrors(&self, motion: usize) -> Option<&Mirrors> {
        self.mirrors.as_ref().filter(|_| self.library.facts()[motion].kicks_left())
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.motors.len()
    }

    /// Pose of the anchor body (torso) in the base, from the joint angles, model order `[rad]`.
    pub fn anchor_in_base(&self, joint_pos: &[f64]) -> Pose<f64> {
        let mut pose = Pose::identity();
        for &j in &self.waist {
            let joint = &self.model.joints[j];
            let body = &self.model.bodies[joint.body];
            pose.pos = pose.point_in_world(Vec3(body.pos));
            let turn = Quat(body.quat).mul(Quat::from_axis_angle(Vec3(joint.axis), joint_pos[j]));
            pose.rot = pose.rot.mul_mat(&turn.to_mat());
        }
        pose
    }

    /// Frame `t` of a motion as a policy observes it: in the clip's own axes. `joints` is room for angles and speeds.
    pub fn reference<'a>(&self, motion: usize, t: usize, joints: &'a mut Vec<f64>) -> ReferenceView<'a, f64> {
        let (frame, n) = (self.library.frame(motion, t), self.joints());
        joints.clear();
        joints.extend(frame[..2 * n].iter().map(|x| f64::from(*x)));
        let at = 2 * n + paid_play::FrameLayout::BODY * self.anchor;
        let x = |k: usize| f64::from(frame[at + k]);
        let (joint_pos, joint_vel) = joints.split_at(n);
        ReferenceView {
            joint_pos,
            joint_vel,
            anchor: Pose { pos: Vec3([x(0), x(1), x(2)]), rot: Quat([x(3), x(4), x(5), x(6)]).to_mat() },
            anchor_ang_vel: Vec3([x(10), x(11), x(12)]),
        }
    }
}

/// Where two orders of names differ first, the robot's and that of the policy's robot file.
fn first_difference(kind: &str, expected: &[String], found: &[String]) -> Option<String> {
    let at = (0..expected.len().max(found.len())).find(|&k| expected.get(k) != found.get(k))?;
    let name = |names: &[String]| names.get(at).map_or("none", String::as_str).to_owned();
    Some(format!("{kind} {at} of its robot file: expected {}, found {}", name(expected), name(found)))
}

/// Joints from the base to a body, the base's end first.
fn chain(model: &RobotModel, mut body: usize) -> Vec<usize> {
    let mut joints = Vec::new();
    while let Some(j) = model.joints.iter().position(|joint| joint.body == body) {
        joints.push(j);
        body = model.bodies[body].parent.unwrap_or(0);
    }
    joints.reverse();
    joints
}

/// A turn about z `[rad]`.
pub(crate) fn about_z(angle: f64) -> Mat3<f64> {
    let (s, c) = angle.sin_cos();
    Mat3([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
}
