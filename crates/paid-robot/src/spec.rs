//! What a robot's TOML adds to its MJCF: control gains, default pose, and the names that the task refers to.

use serde::{Deserialize, Serialize};

/// The robot's TOML file (`configs/robots/*.toml`). Joint and body entries are by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Robot name.
    pub name: String,
    /// Height of the base in the default pose [m].
    pub nominal_height_m: f64,
    /// Share of each joint range that is free of the joint-limit penalty.
    pub soft_limit_factor: f64,
    /// Joint order of motion files without names and of the policy's inputs and outputs.
    pub policy_joint_order: Vec<String>,
    /// Body order of motion files without names.
    pub motion_body_order: Vec<String>,
    /// The body that anchors tracking.
    pub anchor_body: String,
    /// Bodies whose tracking is rewarded and measured; the first is the root.
    pub tracked_bodies: Vec<String>,
    /// Left and right foot.
    pub feet: [String; 2],
    /// Left and right shin, for the ball.
    pub shins: [String; 2],
    /// Bodies whose height decides that tracking failed.
    pub end_effectors: Vec<String>,
    /// Bodies that may touch the ground or the robot without penalty.
    pub allowed_contacts: Vec<String>,
    /// Joints whose action rate is penalised separately.
    pub waist_joints: Vec<String>,
    /// Default joint angles [rad] by joint name; absent joints are zero. A key may contain `*`.
    pub default_pos: Vec<(String, f64)>,
    /// Natural frequency of the joint controllers [Hz].
    pub natural_frequency_hz: f64,
    /// Damping ratio of the joint controllers.
    pub damping_ratio: f64,
    /// Action scale as a share of effort limit over stiffness.
    pub action_scale_factor: f64,
    /// Velocity limit [rad/s] by joint name; a key may contain `*`; the last match holds.
    pub velocity_limit: Vec<(String, f64)>,
}

/// Control numbers per joint, model order.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSpec {
    /// Default angle [rad].
    pub default_pos: Vec<f64>,
    /// Stiffness [N m/rad]: armature times natural frequency squared.
    pub stiffness: Vec<f64>,
    /// Damping [N m s/rad].
    pub damping: Vec<f64>,
    /// Radians of target per unit of action.
    pub action_scale: Vec<f64>,
    /// Velocity limit [rad/s].
    pub velocity_limit: Vec<f64>,
    /// Soft lower and upper limit [rad].
    pub soft_range: Vec<[f64; 2]>,
}
