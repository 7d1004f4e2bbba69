//! What a robot's TOML adds to its MJCF: control gains, default pose, and the names that the task refers to.

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::variant::Difference;

/// The robot's TOML file (`configs/robots/*.toml`). Joint and body entries are by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RobotSpec {
    /// Robot name.
    pub name: String,
    /// Height of the base in the default pose `[m]`.
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
    /// Joints whose action rate is penalized separately; a robot without a waist leaves them out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub waist_joints: Vec<String>,
    /// Default joint angles `[rad]`; joints without an entry are zero.
    pub default_pos: Vec<JointValue>,
    /// Natural frequency of the joint controllers `[Hz]`.
    pub natural_frequency_hz: f64,
    /// Damping ratio of the joint controllers.
    pub damping_ratio: f64,
    /// Stiffness of joints that do not follow the natural frequency `[N m/rad]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub stiffness: Vec<JointValue>,
    /// Damping of joints that do not follow the damping ratio `[N m s/rad]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub damping: Vec<JointValue>,
    /// Action scale as a share of effort limit over stiffness.
    pub action_scale_factor: f64,
    /// Action scale of joints that do not follow the factor `[rad]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub action_scale: Vec<JointValue>,
    /// Velocity limits `[rad/s]`; every joint has one.
    pub velocity_limit: Vec<JointValue>,
    /// The `mode_machine` of the robots that this file is for; empty for a robot that has no such number.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub mode_machines: Vec<u8>,
    /// What some of them have instead of the numbers above and in the MJCF.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub differences: Vec<Difference>,
    /// The file that this came from, for error messages.
    #[serde(skip)]
    pub file: String,
}

/// A number for all joints that a pattern names; the last entry that matches a joint holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointValue {
    /// Joint name; each `*` stands for any characters.
    pub joint: String,
    /// The number, in the unit of the list.
    pub value: f64,
}

/// A fault in a robot's TOML file, or between it and the MJCF.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum SpecError {
    /// Not TOML, or not of this schema.
    #[error("{file}: {message}")]
    Syntax {
        /// File name as given.
        file: String,
        /// Line, key and what was expected.
        message: String,
    },
    /// A number out of range.
    #[error("{file}: '{key}': expected {expected}, found {found}")]
    BadValue {
        /// File name as given.
        file: String,
        /// The key.
        key: String,
        /// What would be right.
        expected: &'static str,
        /// What is there.
        found: f64,
    },
    /// A name that the robot does not have.
    #[error("{file}: '{key}': the robot has no {kind} '{name}'{hint}")]
    UnknownName {
        /// File name as given.
        file: String,
        /// The key.
        key: String,
        /// Body or joint.
        kind: &'static str,
        /// The name.
        name: String,
        /// A suggestion, or nothing.
        hint: String,
    },
    /// A name that occurs twice in a list.
    #[error("{file}: '{key}': '{name}' occurs twice")]
    Duplicate {
        /// File name as given.
        file: String,
        /// The key.
        key: String,
        /// The name.
        name: String,
    },
    /// A list that must name all, or at least one, and does not.
    #[error("{file}: '{key}': {what} is missing")]
    Missing {
        /// File name as given.
        file: String,
        /// The key.
        key: &'static str,
        /// What is missing.
        what: String,
    },
    /// A variant that the file does not have.
    #[error("{file}: expected a robot of mode_machine {known}, found {found}")]
    NoVariant {
        /// File name as given.
        file: String,
        /// The number that was asked for.
        found: u8,
        /// Those of the file.
        known: String,
    },
}

impl RobotSpec {
    /// Reads a robot's TOML; `file` is for error messages only. Names are checked later, against the model.
    ///
    /// # Errors
    /// Bad TOML, an unknown or missing key, a number out of range.
    pub fn from_toml(text: &str, file: &str) -> Result<Self, SpecError> {
        let mut spec: Self = toml::from_str(text).map_err(|e| SpecError::Syntax {
            file: file.to_owned(),
            message: e.to_string().trim_end().to_owned(),
        })?;
        spec.file = file.to_owned();
        let positive = |x: f64| x > 0.0;
        spec.check("nominal_height_m", spec.nominal_height_m, positive, "a positive height [m]")?;
        spec.check(
            "soft_limit_factor",
            spec.soft_limit_factor,
            |x| x > 0.0 && x <= 1.0,
            "a share above 0, at most 1",
        )?;
        spec.check("natural_frequency_hz", spec.natural_frequency_hz, positive, "a positive frequency [Hz]")?;
        spec.check("damping_ratio", spec.damping_ratio, |x| x >= 0.0, "a ratio of at least 0")?;
        spec.check("action_scale_factor", spec.action_scale_factor, positive, "a positive factor")?;
        for (i, entry) in spec.default_pos.iter().enumerate() {
            spec.check(&format!("default_pos[{i}]"), entry.value, |_| true, "a finite angle [rad]")?;
        }
        for (i, entry) in spec.stiffness.iter().enumerate() {
            spec.check(&format!("stiffness[{i}]"), entry.value, positive, "a positive stiffness [N m/rad]")?;
        }
        for (i, entry) in spec.damping.iter().enumerate() {
            let key = format!("damping[{i}]");
            spec.check(&key, entry.value, |x| x >= 0.0, "a damping of at least 0 [N m s/rad]")?;
        }
        for (i, entry) in spec.velocity_limit.iter().enumerate() {
            spec.check(&format!("velocity_limit[{i}]"), entry.value, positive, "a positive speed [rad/s]")?;
        }
        for (i, entry) in spec.action_scale.iter().enumerate() {
            spec.check(&format!("action_scale[{i}]"), entry.value, positive, "a positive angle [rad]")?;
        }
        spec.check_differences()?;
        Ok(spec)
    }

    /// The Unitree G1, embedded in the program.
    ///
    /// # Panics
    /// Never: a test reads the embedded file.
    pub fn g1() -> Self {
        match Self::from_toml(include_str!("../../../../configs/robots/g1.toml"), "configs/robots/g1.toml") {
            Ok(spec) => spec,
            Err(e) => panic!("the embedded robot configuration is broken: {e}"),
        }
    }

    pub(crate) fn check(
        &self,
        key: &str,
        found: f64,
        is_good: impl Fn(f64) -> bool,
        expected: &'static str,
    ) -> Result<(), SpecError> {
        if found.is_finite() && is_good(found) {
            return Ok(());
        }
        Err(SpecError::BadValue { file: self.file.clone(), key: key.to_owned(), expected, found })
    }
}
