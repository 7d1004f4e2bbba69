//! Joint controllers that a policy brings along.

use paid_robot::{JointValue, RobotModel, RobotSpec};

/// Joint control that a policy was trained for, model order.
#[derive(Clone, Debug, PartialEq)]
pub struct Gains {
    /// Stiffness `[N m/rad]`.
    pub stiffness: Vec<f64>,
    /// Damping `[N m s/rad]`.
    pub damping: Vec<f64>,
    /// Torque limits `[N m]` where they are below the robot's; `None`: the robot's.
    pub effort: Option<Vec<f64>>,
}

impl Gains {
    /// True if stiffness and damping are those of `spec` within a thousandth, and there are no torque limits.
    ///
    /// # Errors
    /// If the spec does not fit the robot.
    pub fn are_of(&self, robot: &RobotModel, spec: &RobotSpec) -> Result<bool, paid_robot::SpecError> {
        let own = spec.resolve(robot)?;
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() <= 1e-3 * y.abs());
        let same = near(&self.stiffness, &own.stiffness) && near(&self.damping, &own.damping);
        Ok(same && self.effort.is_none())
    }

    /// Makes the controllers of `robot` and `spec` these, for either engine. Action scales follow, because they are a share of torque limit
    /// over stiffness: code that translates actions must use the values after this call.
    ///
    /// # Panics
    /// If there is not one number per joint.
    pub fn apply(&self, robot: &mut RobotModel, spec: &mut RobotSpec) {
        let joints = robot.joints.len();
        assert_eq!((self.stiffness.len(), self.damping.len()), (joints, joints), "one number per joint");
        let names: Vec<String> = robot.joints.iter().map(|j| j.name.clone()).collect();
        let values = |numbers: &[f64]| {
            let pairs = names.iter().cloned().zip(numbers);
            pairs.map(|(joint, &value)| JointValue { joint, value }).collect::<Vec<_>>()
        };
        // The last entry that matches a joint holds.
        spec.stiffness.extend(values(&self.stiffness));
        spec.damping.extend(values(&self.damping));
        if let Some(effort) = &self.effort {
            assert_eq!(effort.len(), joints, "one number per joint");
            for (joint, limit) in robot.joints.iter_mut().zip(effort) {
                joint.effort_limit = joint.effort_limit.min(*limit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_policys_gains_replace_the_robots_and_never_raise_its_torques() {
        let (mut robot, mut spec) = (RobotModel::g1(), RobotSpec::g1());
        let before = spec.resolve(&robot).expect("the built-in robot");
        let mut gains = Gains {
            stiffness: before.stiffness.clone(),
            damping: before.damping.iter().map(|d| d * 1.0005).collect(),
            effort: None,
        };
        assert!(gains.are_of(&robot, &spec).expect("fits"));
        gains.stiffness[3] = 150.0;
        assert!(!gains.are_of(&robot, &spec).expect("fits"));
        let limit = robot.joints[4].effort_limit;
        gains.effort = Some(vec![0.5 * limit; robot.joints.len()]);
        gains.effort.as_mut().expect("set")[4] = 2.0 * limit;
        gains.apply(&mut robot, &mut spec);
        let after = spec.resolve(&robot).expect("still fits");
        assert_eq!((&after.stiffness, &after.damping), (&gains.stiffness, &gains.damping));
        assert_eq!((robot.joints[4].effort_limit, robot.joints[3].effort_limit), (limit, 0.5 * limit));
        assert!((after.action_scale[3] - spec.action_scale_factor * 0.5 * limit / 150.0).abs() < 1e-12);
    }
}
