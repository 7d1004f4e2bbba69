//! The vendor's motor order against the robot's joint order, by name.

use paid_robot::{OrderError, Permutation};

/// Joints in the order of the G1's motors: depth first, left before right, legs, waist, arms.
pub const G1_MOTORS: [&str; 29] = [
    "left_hip_pitch_joint",
    "left_hip_roll_joint",
    "left_hip_yaw_joint",
    "left_knee_joint",
    "left_ankle_pitch_joint",
    "left_ankle_roll_joint",
    "right_hip_pitch_joint",
    "right_hip_roll_joint",
    "right_hip_yaw_joint",
    "right_knee_joint",
    "right_ankle_pitch_joint",
    "right_ankle_roll_joint",
    "waist_yaw_joint",
    "waist_roll_joint",
    "waist_pitch_joint",
    "left_shoulder_pitch_joint",
    "left_shoulder_roll_joint",
    "left_shoulder_yaw_joint",
    "left_elbow_joint",
    "left_wrist_roll_joint",
    "left_wrist_pitch_joint",
    "left_wrist_yaw_joint",
    "right_shoulder_pitch_joint",
    "right_shoulder_roll_joint",
    "right_shoulder_yaw_joint",
    "right_elbow_joint",
    "right_wrist_roll_joint",
    "right_wrist_pitch_joint",
    "right_wrist_yaw_joint",
];

/// Where each joint of a list is among the motors: entry `j` is the motor of joint `j`.
///
/// # Errors
/// If the list does not name the G1's joints once each.
pub fn motors_of<A: AsRef<str>>(joints: &[A]) -> Result<Vec<usize>, OrderError> {
    Ok(Permutation::between(&G1_MOTORS, joints)?.indices().to_vec())
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_robot::{RobotModel, RobotSpec};

    #[test]
    fn the_models_joints_are_in_motor_order_and_the_policys_are_not() {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let identity: Vec<usize> = (0..29).collect();
        assert_eq!(motors_of(&model.joint_names()).expect("names"), identity);
        let policy = motors_of(&spec.policy_joint_order).expect("names");
        assert_eq!(policy[..4], [0, 6, 12, 1]);
    }

    #[test]
    fn a_missing_joint_is_named() {
        let error = motors_of(&G1_MOTORS[1..]).expect_err("28 joints").to_string();
        assert!(error.contains("left_hip_pitch_joint"), "{error}");
    }
}
