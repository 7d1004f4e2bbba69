//! The robots of one make that episodes are drawn from.

use paid_physics::{EnvParams, MotorScale};
use paid_robot::{ControlSpec, RobotModel, RobotSpec};

use crate::TaskError;

/// A robot relative to the one of the files, model order.
#[derive(Clone, Debug)]
pub(crate) struct Variant {
    motors: Vec<MotorScale>,
    masses: Vec<f64>,
}

/// One number over another; both may be zero.
fn ratio(number: f64, over: f64) -> f64 {
    if number == over { 1.0 } else { number / over }
}

impl Variant {
    /// The robots that report `mode_machines`. `control` is what `spec` gives for `robot`.
    pub(crate) fn all(
        robot: &RobotModel,
        spec: &RobotSpec,
        control: &ControlSpec,
        mode_machines: &[u8],
    ) -> Result<Vec<Self>, TaskError> {
        let wrong =
            |error: paid_robot::SpecError| TaskError::Robot(format!("randomization.mode_machines: {error}"));
        let variant = |&mode_machine: &u8| {
            let (other, spec) = spec.as_variant(robot, mode_machine).map_err(wrong)?;
            let own = spec.resolve(&other).map_err(wrong)?;
            let motor = |j: usize| MotorScale {
                armature: ratio(other.joints[j].armature, robot.joints[j].armature),
                stiffness: ratio(own.stiffness[j], control.stiffness[j]),
                damping: ratio(own.damping[j], control.damping[j]),
                effort: ratio(other.joints[j].effort_limit, robot.joints[j].effort_limit),
                friction: 1.0,
            };
            let mass = |(other, body): (&paid_robot::Body, &paid_robot::Body)| ratio(other.mass, body.mass);
            Ok(Self {
                motors: (0..robot.joints.len()).map(motor).collect(),
                masses: other.bodies.iter().zip(&robot.bodies).map(mass).collect(),
            })
        };
        mode_machines.iter().map(variant).collect()
    }

    /// Makes the robot of an episode this one. The places of its links stay those of the files.
    pub(crate) fn apply(&self, params: &mut EnvParams) {
        if params.motor_scale.is_empty() {
            params.motor_scale.clone_from(&self.motors);
        } else {
            for (scale, own) in params.motor_scale.iter_mut().zip(&self.motors) {
                scale.armature *= own.armature;
                scale.stiffness *= own.stiffness;
                scale.damping *= own.damping;
                scale.effort *= own.effort;
            }
        }
        if params.mass_scale.is_empty() {
            params.mass_scale.clone_from(&self.masses);
        } else {
            params.mass_scale.iter_mut().zip(&self.masses).for_each(|(scale, own)| *scale *= own);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_robot::SpecError;

    #[test]
    fn motors_and_masses_are_relative_to_the_robot_of_the_files() -> Result<(), SpecError> {
        let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
        let control = spec.resolve(&robot)?;
        let variants = Variant::all(&robot, &spec, &control, &[5, 15]).expect("known");
        let mut params = EnvParams { mass_scale: vec![1.1; robot.bodies.len()], ..EnvParams::default() };
        variants[0].apply(&mut params);
        assert!(params.motor_scale.iter().all(|motor| *motor == MotorScale::ONE));
        variants[1].apply(&mut params);
        // Gears of 22.5 instead of 14.3: armature 0.025101925 over 0.01017752, 139 N m over 88.
        let hip = params.motor_scale[robot.joint_index("left_hip_pitch_joint").expect("joint")];
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-5, "{a} is not {b}");
        [hip.armature, hip.stiffness, hip.damping].into_iter().for_each(|x| near(x, 2.466_409));
        near(hip.effort, 1.579_545);
        let wrist = robot.body_index("right_wrist_pitch_link").expect("body");
        near(params.mass_scale[wrist], 1.1 * 0.684 / 0.48405);
        near(params.mass_scale[0], 1.1);
        let error = Variant::all(&robot, &spec, &control, &[6]).expect_err("a locked waist").to_string();
        assert!(error.contains("randomization.mode_machines: configs/robots/g1.toml: expected"), "{error}");
        Ok(())
    }
}
