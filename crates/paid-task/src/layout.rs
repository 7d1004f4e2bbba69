//! What the numbers of an observation mean: the contract of a policy file.

use paid_robot::RobotSpec;
use serde::{Deserialize, Serialize};

/// A named slice of an observation vector.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationTerm {
    /// Name, unique within its group.
    pub name: String,
    /// First index in the vector.
    pub offset: usize,
    /// Number of values.
    pub size: usize,
    /// What the values run over: `joints` (the robot's policy joint order), `x,y,z`, ...
    pub order: String,
    /// Frame in which it is expressed; `joint` for joint coordinates.
    pub frame: String,
    /// SI unit; empty for pure numbers.
    pub unit: String,
    /// Factor on the physical value before normalization.
    pub scale: f64,
}

/// Name of the ball's term where the policy sees a rolling ball where it will be.
pub const BALL_AT_STRIKE: &str = "ball_at_strike";

/// Terms of the policy's and the critic's observation, in order.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ObservationLayout {
    /// The policy's terms.
    pub policy: Vec<ObservationTerm>,
    /// The critic's terms.
    pub critic: Vec<ObservationTerm>,
}

fn terms(list: &[(&str, usize, &str, &str, &str)]) -> Vec<ObservationTerm> {
    let mut offset = 0;
    list.iter()
        .map(|&(name, size, order, frame, unit)| {
            let term = ObservationTerm {
                name: name.into(),
                offset,
                size,
                order: order.into(),
                frame: frame.into(),
                unit: unit.into(),
                scale: 1.0,
            };
            offset += size;
            term
        })
        .collect()
}

impl ObservationLayout {
    /// The layout for a robot: policy 160 and critic 292 numbers for 29 joints and 14 tracked bodies. Joint vectors are in
    /// the policy's joint order; `base` is body 0, `anchor` the robot's anchor body.
    ///
    /// With `lead_ball` ([`crate::ObservationPreset::lead_ball`]) the ball's term is called `ball_at_strike`.
    pub fn new(spec: &RobotSpec, lead_ball: bool) -> Self {
        let ball = if lead_ball { BALL_AT_STRIKE } else { "ball_pos" };
        let joints = spec.policy_joint_order.len();
        let bodies = spec.tracked_bodies.len();
        let rotation = "first two columns of the rotation, row by row";
        Self {
            policy: terms(&[
                ("reference_joint_pos", joints, "joints", "joint", "rad"),
                ("reference_joint_vel", joints, "joints", "joint", "rad/s"),
                ("projected_gravity", 3, "x,y,z", "base", ""),
                ("reference_anchor_ang_vel", 3, "x,y,z", "world", "rad/s"),
                ("base_ang_vel", 3, "x,y,z", "base", "rad/s"),
                ("joint_pos_rel", joints, "joints", "joint", "rad"),
                ("joint_vel", joints, "joints", "joint", "rad/s"),
                ("last_action", joints, "joints", "joint", ""),
                (ball, 3, "x,y,z", "base", "m"),
                ("goal_pos", 3, "x,y,z", "base", "m"),
            ]),
            critic: terms(&[
                ("reference_joint_pos", joints, "joints", "joint", "rad"),
                ("reference_joint_vel", joints, "joints", "joint", "rad/s"),
                ("anchor_pos_error", 3, "x,y,z", "anchor", "m"),
                ("anchor_ori_error", 6, rotation, "anchor", ""),
                ("body_pos", 3 * bodies, "tracked bodies; x,y,z", "anchor", "m"),
                ("body_ori", 6 * bodies, &format!("tracked bodies; {rotation}"), "anchor", ""),
                ("base_lin_vel", 3, "x,y,z", "base", "m/s"),
                ("base_ang_vel", 3, "x,y,z", "base", "rad/s"),
                ("joint_pos_rel", joints, "joints", "joint", "rad"),
                ("joint_vel", joints, "joints", "joint", "rad/s"),
                ("last_action", joints, "joints", "joint", ""),
                (ball, 3, "x,y,z", "base", "m"),
                ("goal_pos", 3, "x,y,z", "base", "m"),
            ]),
        }
    }

    /// Length of the policy's observation.
    pub fn policy_dim(&self) -> usize {
        self.policy.iter().map(|t| t.size).sum()
    }

    /// Length of the critic's observation.
    pub fn critic_dim(&self) -> usize {
        self.critic.iter().map(|t| t.size).sum()
    }
}
