//! The contract of a robot's policies.

use paid_policy::contract::{Contract, FORMAT, JointContract, RecurrentContract};
use paid_policy::observation::ObservationId;
use paid_policy::{Dimensions, ObservationTerms, PlayContract, Policy};
use paid_robot::{Permutation, RobotModel, RobotSpec};

use crate::{PlayError, PlayPreset};

/// What an action means, in the contract's words.
pub const ACTION: &str = "joint position target = default_pos + action_scale * action";
/// The command that the policy follows, under the released name.
pub const COMMAND: &str = "motion";

/// The contract of any policy of this robot in this project's task: joints, gains, observation. Its license is empty, and it is
/// feed-forward. `observation` is the task's list of the policy's terms.
///
/// # Errors
/// If the robot's gains cannot be resolved.
pub fn robot_contract(
    model: &RobotModel,
    spec: &RobotSpec,
    control_period_s: f64,
    observation: &[ObservationId],
) -> Result<Contract, PlayError> {
    let wrong = |error: &dyn core::fmt::Display| PlayError::Robot(error.to_string());
    let control = spec.resolve(model).map_err(|e| wrong(&e))?;
    let order =
        Permutation::between(&model.joint_names(), &spec.policy_joint_order).map_err(|e| wrong(&e))?;
    let joint = |&j: &usize| JointContract {
        name: model.joints[j].name.clone(),
        default_pos: control.default_pos[j],
        stiffness: control.stiffness[j],
        damping: control.damping[j],
        action_scale: control.action_scale[j],
    };
    Ok(Contract {
        format: FORMAT,
        robot: spec.name.clone(),
        mode_machines: Vec::new(),
        license: String::new(),
        control_period_s,
        action: ACTION.to_owned(),
        joints: order.indices().iter().map(joint).collect(),
        anchor_body: spec.anchor_body.clone(),
        bodies: spec.tracked_bodies.clone(),
        observation: ObservationTerms::new(observation, Dimensions::of(spec)).terms().to_vec(),
        commands: vec![COMMAND.to_owned()],
        recurrent: None,
        reference: None,
        play: None,
    })
}

/// The contract of a policy's file; `license` are the terms of the motions that it was trained on.
///
/// # Errors
/// If the robot's gains cannot be resolved.
pub fn policy_contract(
    model: &RobotModel,
    spec: &RobotSpec,
    play: &PlayPreset,
    policy: &Policy,
    license: &str,
) -> Result<Contract, PlayError> {
    let lstm = &policy.net.lstm;
    Ok(Contract {
        license: license.to_owned(),
        mode_machines: play.randomization.mode_machines.clone(),
        recurrent: lstm.first().map(|l| RecurrentContract { layers: lstm.len(), hidden: l.size }),
        play: Some(play.contract()).filter(|play| *play != PlayContract::default()),
        ..robot_contract(model, spec, play.control_dt_s(), &play.observations.policy)?
    })
}
