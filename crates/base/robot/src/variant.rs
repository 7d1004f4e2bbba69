//! Robots of one make that differ in motors and links: the G1s by the `mode_machine` that they report.

use serde::{Deserialize, Serialize};

use crate::names::hint;
use crate::spec::{JointValue, SpecError};
use crate::{RobotModel, RobotSpec};

/// What some robots have instead of the numbers of the MJCF and of the rest of the file. What it leaves out stays.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    /// The `mode_machine` of the robots that have it.
    pub mode_machines: Vec<u8>,
    /// Largest torques `[N m]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effort_limit: Vec<JointValue>,
    /// Velocity limits `[rad/s]`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity_limit: Vec<JointValue>,
    /// Rotor inertias reflected to the joint `[kg m^2]`. The gains follow them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub armature: Vec<JointValue>,
    /// Links of another mass or place.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub links: Vec<LinkDifference>,
}

/// A link of another mass or place.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinkDifference {
    /// Name of the body.
    pub body: String,
    /// Origin in the parent's frame `[m]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pos: Option<[f64; 3]>,
    /// Mass `[kg]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mass: Option<f64>,
    /// Center of mass in the body frame `[m]`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub com: Option<[f64; 3]>,
    /// Inertia about the center of mass in body axes [kg m^2]: xx, yy, zz, xy, xz, yz.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 6]>,
}

impl RobotSpec {
    /// Model and spec of the robot that reports `mode_machine`, from those of the file. Action scales stay: what an action means does not
    /// depend on the robot that carries it out.
    ///
    /// # Errors
    /// If the file is not for such a robot, or an entry does not fit the model.
    pub fn as_variant(&self, model: &RobotModel, mode_machine: u8) -> Result<(RobotModel, Self), SpecError> {
        if !self.mode_machines.contains(&mode_machine) {
            let known: Vec<String> = self.mode_machines.iter().map(u8::to_string).collect();
            return Err(SpecError::NoVariant {
                file: self.file.clone(),
                found: mode_machine,
                known: known.join(", "),
            });
        }
        let scale = |(joint, value): (String, f64)| JointValue { joint, value };
        let scales = model.joint_names().into_iter().zip(self.resolve(model)?.action_scale).map(scale);
        let mut spec = Self { action_scale: scales.collect(), ..self.clone() };
        let mut model = model.clone();
        for (i, difference) in self.differences.iter().enumerate() {
            if !difference.mode_machines.contains(&mode_machine) {
                continue;
            }
            let key = |list: &str| format!("differences[{i}].{list}");
            let armature = self.per_joint(&model, &key("armature"), &difference.armature)?;
            let effort = self.per_joint(&model, &key("effort_limit"), &difference.effort_limit)?;
            for (joint, (armature, effort)) in model.joints.iter_mut().zip(armature.into_iter().zip(effort)) {
                joint.armature = armature.unwrap_or(joint.armature);
                joint.effort_limit = effort.unwrap_or(joint.effort_limit);
            }
            for link in &difference.links {
                self.change(&mut model, &key("links"), link)?;
            }
            spec.velocity_limit.extend(difference.velocity_limit.iter().cloned());
        }
        spec.resolve(&model)?;
        Ok((model, spec))
    }

    fn change(&self, model: &mut RobotModel, key: &str, link: &LinkDifference) -> Result<(), SpecError> {
        let index = model.body_index(&link.body).ok_or_else(|| SpecError::UnknownName {
            file: self.file.clone(),
            key: key.to_owned(),
            kind: "body",
            name: link.body.clone(),
            hint: hint(&link.body, &model.body_names()),
        })?;
        let body = &mut model.bodies[index];
        body.pos = link.pos.unwrap_or(body.pos);
        body.mass = link.mass.unwrap_or(body.mass);
        body.com = link.com.unwrap_or(body.com);
        body.inertia = link.inertia.unwrap_or(body.inertia);
        Ok(())
    }

    /// Checks the numbers of the differences, and that each is for robots of this file.
    pub(crate) fn check_differences(&self) -> Result<(), SpecError> {
        for (i, difference) in self.differences.iter().enumerate() {
            let key = |name: &str| format!("differences[{i}].{name}");
            let own = |mode: &&u8| self.mode_machines.contains(mode);
            if let Some(mode) = difference.mode_machines.iter().find(|mode| !own(mode)) {
                let expected = "numbers of the file's 'mode_machines'";
                self.check(&key("mode_machines"), f64::from(*mode), |_| false, expected)?;
            }
            for (list, entries, expected) in [
                ("effort_limit", &difference.effort_limit, "a positive torque [N m]"),
                ("velocity_limit", &difference.velocity_limit, "a positive speed [rad/s]"),
                ("armature", &difference.armature, "a positive inertia [kg m^2]"),
            ] {
                for (k, entry) in entries.iter().enumerate() {
                    self.check(&key(&format!("{list}[{k}]")), entry.value, |x| x > 0.0, expected)?;
                }
            }
            for (k, link) in difference.links.iter().enumerate() {
                let key = |name: &str| key(&format!("links[{k}].{name}"));
                self.check(&key("mass"), link.mass.unwrap_or(1.0), |x| x > 0.0, "a positive mass [kg]")?;
                for (name, place) in [("pos", link.pos), ("com", link.com)] {
                    for x in place.into_iter().flatten() {
                        self.check(&key(name), x, |_| true, "finite numbers [m]")?;
                    }
                }
                for (axis, x) in link.inertia.into_iter().flatten().enumerate() {
                    let expected = "finite numbers [kg m^2], xx, yy and zz positive";
                    self.check(&key("inertia"), x, |x| axis >= 3 || x > 0.0, expected)?;
                }
            }
        }
        Ok(())
    }
}
