//! Left and right of a robot.

use paid_policy::observation::ObservationId;
use paid_policy::{Mirrors, Sides};
use paid_robot::mirror::mirrored_names;
use paid_robot::{ControlSpec, Permutation, RobotModel, RobotSpec};

/// How a policy's observation of these terms and its actions read in a mirrored world.
///
/// # Errors
/// Why the robot has no mirror image.
pub fn policy_mirrors(
    robot: &RobotModel,
    spec: &RobotSpec,
    terms: &[ObservationId],
) -> Result<Mirrors, String> {
    let control = spec.resolve(robot).map_err(|e| e.to_string())?;
    let to_model = Permutation::between(&robot.joint_names(), &spec.policy_joint_order)
        .map_err(|e| format!("policy_joint_order: {e}"))?;
    Ok(Mirrors::new(&sides(robot, spec, &control, to_model.indices())?, terms))
}

/// Which joints and tracked bodies are each other's image. Joints that rest or act otherwise than their image make a robot asymmetric.
/// `to_model` is the model joint of each policy joint.
///
/// # Errors
/// Why the robot has no mirror image.
pub fn sides(
    robot: &RobotModel,
    spec: &RobotSpec,
    control: &ControlSpec,
    to_model: &[usize],
) -> Result<Sides, String> {
    let images = robot.mirrored_joints().map_err(|e| e.to_string())?;
    let joint = |&m: &usize| {
        let (image, sign) = images[m];
        let differ = |values: &[f64], sign: f64| (values[m] - sign * values[image]).abs() > 1e-9;
        if differ(&control.default_pos, sign) || differ(&control.action_scale, 1.0) {
            let [joint, image] = [m, image].map(|j| &robot.joints[j].name);
            return Err(format!("'{joint}' rests or acts otherwise than its image '{image}'"));
        }
        let place = to_model.iter().position(|j| *j == image);
        Ok((place.ok_or_else(|| format!("the policy does not have '{}'", robot.joints[image].name))?, sign))
    };
    Ok(Sides {
        joints: to_model.iter().map(joint).collect::<Result<_, _>>()?,
        bodies: mirrored_names("tracked body", &spec.tracked_bodies).map_err(|e| e.to_string())?,
    })
}
