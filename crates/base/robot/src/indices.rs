//! The names of a robot's TOML as positions in its model.

use crate::names::hint;
use crate::spec::SpecError;
use crate::{Permutation, RobotModel, RobotSpec};

/// Positions in model order of everything that the TOML names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RobotIndices {
    /// The body that anchors tracking.
    pub anchor: usize,
    /// Tracked bodies, in the TOML's order; the first is the root.
    pub tracked: Vec<usize>,
    /// Left and right foot.
    pub feet: [usize; 2],
    /// Left and right shin.
    pub shins: [usize; 2],
    /// Bodies whose height decides that tracking failed.
    pub end_effectors: Vec<usize>,
    /// Bodies that may touch ground and robot without penalty.
    pub allowed_contacts: Vec<usize>,
    /// Joints whose action rate is penalized separately.
    pub waist_joints: Vec<usize>,
    /// Brings joint values in model order into the policy's order.
    pub policy_from_model: Permutation,
    /// Brings joint values in the policy's order (also that of motion files) into model order.
    pub model_from_policy: Permutation,
    /// Brings body values in the order of motion files into model order.
    pub model_from_motion_bodies: Permutation,
}

impl RobotSpec {
    /// Finds every name in `model`.
    ///
    /// # Errors
    /// A name that the model does not have, one that occurs twice in its list, or an order that leaves one out.
    pub fn indices(&self, model: &RobotModel) -> Result<RobotIndices, SpecError> {
        let (bodies, joints) = (model.body_names(), model.joint_names());
        let body = |key: &'static str, names: &[String]| self.find_all(key, "body", names, &bodies);
        let joint = |key: &'static str, names: &[String]| self.find_all(key, "joint", names, &joints);
        let pair =
            |key: &'static str, names: &[String; 2]| body(key, names).map(|found| [found[0], found[1]]);

        let tracked = body("tracked_bodies", &self.tracked_bodies)?;
        if tracked.first() != Some(&0) {
            let what = format!("the root '{}' as first entry", bodies[0]);
            return Err(SpecError::Missing { file: self.file.clone(), key: "tracked_bodies", what });
        }
        let order = |key: &'static str, found: Vec<usize>, names: &[String]| match names
            .iter()
            .enumerate()
            .find(|(i, _)| !found.contains(i))
        {
            Some((_, name)) => {
                let what = format!("'{name}'");
                Err(SpecError::Missing { file: self.file.clone(), key, what })
            }
            None => Ok(Permutation::from_unique(found)),
        };
        let policy = joint("policy_joint_order", &self.policy_joint_order)?;
        let policy_from_model = order("policy_joint_order", policy, &joints)?;
        let motion = body("motion_body_order", &self.motion_body_order)?;
        let motion_from_model = order("motion_body_order", motion, &bodies)?;
        Ok(RobotIndices {
            anchor: self.find("anchor_body", "body", &self.anchor_body, &bodies)?,
            tracked,
            feet: pair("feet", &self.feet)?,
            shins: pair("shins", &self.shins)?,
            end_effectors: body("end_effectors", &self.end_effectors)?,
            allowed_contacts: body("allowed_contacts", &self.allowed_contacts)?,
            waist_joints: joint("waist_joints", &self.waist_joints)?,
            model_from_policy: policy_from_model.inverse(),
            policy_from_model,
            model_from_motion_bodies: motion_from_model.inverse(),
        })
    }

    fn find(&self, key: &str, kind: &'static str, name: &str, known: &[String]) -> Result<usize, SpecError> {
        known.iter().position(|k| k == name).ok_or_else(|| SpecError::UnknownName {
            file: self.file.clone(),
            key: key.to_owned(),
            kind,
            name: name.to_owned(),
            hint: hint(name, known),
        })
    }

    fn find_all(
        &self,
        key: &str,
        kind: &'static str,
        names: &[String],
        known: &[String],
    ) -> Result<Vec<usize>, SpecError> {
        let mut found = Vec::with_capacity(names.len());
        for (i, name) in names.iter().enumerate() {
            let key = format!("{key}[{i}]");
            let index = self.find(&key, kind, name, known)?;
            if found.contains(&index) {
                return Err(SpecError::Duplicate { file: self.file.clone(), key, name: name.clone() });
            }
            found.push(index);
        }
        Ok(found)
    }
}
