//! Gains, scales and limits of the joint controllers.

use std::f64::consts::TAU;

use crate::names::{hint, matches};
use crate::spec::{JointValue, SpecError};
use crate::{RobotModel, RobotSpec};

/// Control numbers per joint, model order.
#[derive(Clone, Debug, PartialEq)]
pub struct ControlSpec {
    /// Default angle `[rad]`.
    pub default_pos: Vec<f64>,
    /// Stiffness [N m/rad]: armature times natural frequency squared.
    pub stiffness: Vec<f64>,
    /// Damping [N m s/rad]: twice damping ratio, armature and natural frequency.
    pub damping: Vec<f64>,
    /// Radians of target per unit of action: factor times effort limit over stiffness.
    pub action_scale: Vec<f64>,
    /// Velocity limit `[rad/s]`.
    pub velocity_limit: Vec<f64>,
    /// Soft lower and upper limit `[rad]`: the inner share of the range.
    pub soft_range: Vec<[f64; 2]>,
}

impl RobotSpec {
    /// The control numbers of `model`'s joints (formulas of the paper's public release).
    ///
    /// # Errors
    /// A pattern that matches no joint, a joint without velocity limit or armature, a default angle outside the range.
    pub fn resolve(&self, model: &RobotModel) -> Result<ControlSpec, SpecError> {
        let omega = TAU * self.natural_frequency_hz;
        let default_pos = self.per_joint(model, "default_pos", &self.default_pos)?;
        let default_pos: Vec<f64> = default_pos.into_iter().map(|v| v.unwrap_or(0.0)).collect();
        let velocity_limit = self.per_joint(model, "velocity_limit", &self.velocity_limit)?;
        let stiffness = self.per_joint(model, "stiffness", &self.stiffness)?;
        let damping = self.per_joint(model, "damping", &self.damping)?;
        let action_scale = self.per_joint(model, "action_scale", &self.action_scale)?;
        let mut control = ControlSpec {
            default_pos,
            stiffness: Vec::new(),
            damping: Vec::new(),
            action_scale: Vec::new(),
            velocity_limit: Vec::new(),
            soft_range: Vec::new(),
        };
        for (j, joint) in model.joints.iter().enumerate() {
            let missing = |key, what: &str| SpecError::Missing {
                file: self.file.clone(),
                key,
                what: format!("{what} of joint '{}'", joint.name),
            };
            let [lo, hi] = joint.range;
            let found = control.default_pos[j];
            if found < lo || found > hi {
                let key = format!("default_pos of '{}'", joint.name);
                let expected = "an angle within the joint's range";
                return Err(SpecError::BadValue { file: self.file.clone(), key, expected, found });
            }
            if joint.armature <= 0.0 && (stiffness[j].is_none() || damping[j].is_none()) {
                return Err(missing(
                    "natural_frequency_hz",
                    "the MJCF's armature, which the gains follow from,",
                ));
            }
            let own = 2.0 * self.damping_ratio * joint.armature * omega;
            control.damping.push(damping[j].unwrap_or(own));
            let stiffness = stiffness[j].unwrap_or(joint.armature * omega * omega);
            control.stiffness.push(stiffness);
            let own = self.action_scale_factor * joint.effort_limit / stiffness;
            control.action_scale.push(action_scale[j].unwrap_or(own));
            control
                .velocity_limit
                .push(velocity_limit[j].ok_or_else(|| missing("velocity_limit", "the limit"))?);
            let (middle, half) = (0.5 * (lo + hi), 0.5 * self.soft_limit_factor * (hi - lo));
            control.soft_range.push([middle - half, middle + half]);
        }
        Ok(control)
    }

    /// One entry per joint of `model`; the last pattern that matches holds.
    pub(crate) fn per_joint(
        &self,
        model: &RobotModel,
        key: &str,
        entries: &[JointValue],
    ) -> Result<Vec<Option<f64>>, SpecError> {
        let mut values = vec![None; model.joints.len()];
        for (i, entry) in entries.iter().enumerate() {
            let mut used = false;
            for (joint, value) in model.joints.iter().zip(&mut values) {
                if matches(&entry.joint, &joint.name) {
                    *value = Some(entry.value);
                    used = true;
                }
            }
            if !used {
                return Err(SpecError::UnknownName {
                    file: self.file.clone(),
                    key: format!("{key}[{i}]"),
                    kind: "joint",
                    name: entry.joint.clone(),
                    hint: hint(&entry.joint, &model.joint_names()),
                });
            }
        }
        Ok(values)
    }
}
