//! The robot's TOML: gains by hand, and its faults.

use paid_robot::{RobotModel, RobotSpec, SpecError};

const TOML: &str = include_str!("../../../../configs/robots/g1.toml");

fn read_changed(from: &str, to: &str) -> Result<RobotSpec, SpecError> {
    assert!(TOML.contains(from), "'{from}' is in the file");
    RobotSpec::from_toml(&TOML.replacen(from, to, 1), "robot.toml")
}

/// The error of reading, resolving or finding names after a change.
fn fault(from: &str, to: &str) -> String {
    let model = RobotModel::g1();
    let result = read_changed(from, to).and_then(|s| s.resolve(&model).and(s.indices(&model)).map(|_| ()));
    result.expect_err("the change is a fault").to_string()
}

#[test]
fn gains_and_scales_are_those_computed_by_hand() {
    let model = RobotModel::g1();
    let control = RobotSpec::g1().resolve(&model).unwrap();
    // (2 pi 10 Hz)^2 = 3947.8417604; times armature; damping 4 armature 62.8318531; scale 0.25 effort / stiffness.
    let by_hand = [
        ("left_hip_pitch_joint", -0.312, 40.179238, 2.557890, 0.547546, 32.0),
        ("right_hip_roll_joint", 0.0, 99.098428, 6.308801, 0.350661, 20.0),
        ("left_knee_joint", 0.669, 99.098428, 6.308801, 0.350661, 20.0),
        ("right_ankle_pitch_joint", -0.363, 28.501246, 1.814445, 0.438577, 37.0),
        ("waist_roll_joint", 0.0, 28.501246, 1.814445, 0.438577, 37.0),
        ("waist_yaw_joint", 0.0, 40.179238, 2.557890, 0.547546, 32.0),
        ("left_shoulder_roll_joint", 0.2, 14.250623, 0.907223, 0.438577, 37.0),
        ("right_shoulder_roll_joint", -0.2, 14.250623, 0.907223, 0.438577, 37.0),
        ("left_elbow_joint", 0.6, 14.250623, 0.907223, 0.438577, 37.0),
        ("right_wrist_yaw_joint", 0.0, 16.778327, 1.068142, 0.074501, 22.0),
    ];
    for (name, pos, kp, kd, scale, speed) in by_hand {
        let j = model.joint_index(name).unwrap();
        let near =
            |a: f64, b: f64| assert!((a - b).abs() < 2e-6 * b.abs().max(1.0), "{name}: {a} is not {b}");
        near(control.default_pos[j], pos);
        near(control.stiffness[j], kp);
        near(control.damping[j], kd);
        near(control.action_scale[j], scale);
        near(control.velocity_limit[j], speed);
    }
    // Knee range -0.087267 to 2.8798: middle 1.3962665, half of 0.9 of the width 1.33518015.
    let [lo, hi] = control.soft_range[model.joint_index("left_knee_joint").unwrap()];
    assert!((lo - 0.06108635).abs() < 1e-9 && (hi - 2.73144665).abs() < 1e-9, "{lo} {hi}");
}

#[test]
fn a_robot_without_a_waist_leaves_its_joints_out() {
    let line = TOML.lines().find(|l| l.starts_with("waist_joints")).unwrap();
    let spec = read_changed(line, "").unwrap();
    assert!(spec.waist_joints.is_empty());
    assert!(spec.indices(&RobotModel::g1()).unwrap().waist_joints.is_empty());
}

#[test]
fn all_names_are_found_and_orders_lead_back() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let at = spec.indices(&model).unwrap();
    assert_eq!(at.tracked.len(), 14);
    assert_eq!(model.bodies[at.feet[1]].name, "right_ankle_roll_link");
    let names = model.joint_names();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let policy = at.policy_from_model.apply(&names);
    assert_eq!(policy, spec.policy_joint_order);
    assert_eq!(at.model_from_policy.apply(&policy), names);
    let motion: Vec<&str> = spec.motion_body_order.iter().map(String::as_str).collect();
    assert_eq!(at.model_from_motion_bodies.apply(&motion), model.body_names());
    // Motion bodies follow the policy's joints.
    for (joint, body) in policy.iter().zip(&motion[1..]) {
        assert_eq!(model.bodies[model.joints[model.joint_index(joint).unwrap()].body].name, *body);
    }
}

#[test]
fn a_misspelt_name_is_an_error_with_file_key_and_the_nearest_name() {
    assert_eq!(
        fault("anchor_body = \"torso_link\"", "anchor_body = \"torso_lnk\""),
        "robot.toml: 'anchor_body': the robot has no body 'torso_lnk' (did you mean 'torso_link'?)"
    );
    assert_eq!(
        fault("shins = [\"left_knee_link\"", "shins = [\"left_kne_link\""),
        "robot.toml: 'shins[0]': the robot has no body 'left_kne_link' (did you mean 'left_knee_link'?)"
    );
    assert_eq!(
        fault("joint = \"left_shoulder_roll_joint\"", "joint = \"left_shoulder_rol_joint\""),
        "robot.toml: 'default_pos[4]': the robot has no joint 'left_shoulder_rol_joint' (did you mean 'left_shoulder_roll_joint'?)"
    );
}

#[test]
fn gains_by_name_replace_those_that_follow_from_the_armature() {
    let model = RobotModel::g1();
    let own = RobotSpec::g1().resolve(&model).unwrap();
    let named = "damping_ratio = 2.0\nstiffness = [{ joint = \"*_knee_joint\", value = 150.0 }]\n\
                 damping = [{ joint = \"left_knee_joint\", value = 4.0 }]";
    let spec = read_changed("damping_ratio = 2.0", named).unwrap();
    let control = spec.resolve(&model).unwrap();
    let [left, right] = ["left", "right"]
        .map(|side| model.joints.iter().position(|j| j.name == format!("{side}_knee_joint")).unwrap());
    assert_eq!((control.stiffness[left], control.stiffness[right]), (150.0, 150.0));
    assert_eq!((control.damping[left], control.damping[right]), (4.0, own.damping[right]));
    assert!((control.action_scale[left] - 0.25 * model.joints[left].effort_limit / 150.0).abs() < 1e-12);
    assert_eq!((control.stiffness[0], control.damping[0]), (own.stiffness[0], own.damping[0]));
    let bad =
        fault("damping_ratio = 2.0", "damping_ratio = 2.0\nstiffness = [{ joint = \"*\", value = 0.0 }]");
    assert_eq!(bad, "robot.toml: 'stiffness[0]': expected a positive stiffness [N m/rad], found 0");
}

#[test]
fn faults_of_lists_and_numbers_name_the_key() {
    let twice = fault("feet = [\"left_ankle_roll_link\"", "feet = [\"right_ankle_roll_link\"");
    assert_eq!(twice, "robot.toml: 'feet[1]': 'right_ankle_roll_link' occurs twice");
    let order = fault("\"left_hip_pitch_joint\", \"right_hip_pitch_joint\", ", "\"right_hip_pitch_joint\", ");
    assert_eq!(order, "robot.toml: 'policy_joint_order': 'left_hip_pitch_joint' is missing");
    let root = fault("\"pelvis\",\n    \"left_hip_roll_link\"", "\"left_hip_roll_link\"");
    assert_eq!(root, "robot.toml: 'tracked_bodies': the root 'pelvis' as first entry is missing");
    let limit = fault("    { joint = \"*_elbow_joint\", value = 37.0 },\n", "");
    assert_eq!(limit, "robot.toml: 'velocity_limit': the limit of joint 'left_elbow_joint' is missing");
    let factor = fault("soft_limit_factor = 0.9", "soft_limit_factor = 1.5");
    assert_eq!(factor, "robot.toml: 'soft_limit_factor': expected a share above 0, at most 1, found 1.5");
    let nan = fault("natural_frequency_hz = 10.0", "natural_frequency_hz = nan");
    assert_eq!(nan, "robot.toml: 'natural_frequency_hz': expected a positive frequency [Hz], found NaN");
    let pose = fault("value = 0.669", "value = 6.69");
    assert_eq!(
        pose,
        "robot.toml: 'default_pos of 'left_knee_joint'': expected an angle within the joint's range, found 6.69"
    );
}

#[test]
fn an_unknown_or_missing_key_is_an_error_with_its_name() {
    let unknown = fault("damping_ratio = 2.0", "damping_rato = 2.0");
    assert!(unknown.starts_with("robot.toml: ") && unknown.contains("damping_rato"), "{unknown}");
    let missing = fault("damping_ratio = 2.0\n", "");
    assert!(missing.contains("missing field `damping_ratio`"), "{missing}");
}

#[test]
fn writing_and_reading_changes_nothing() {
    let spec = RobotSpec::g1();
    let text = toml::to_string(&spec).unwrap();
    let mut back = RobotSpec::from_toml(&text, "copy").unwrap();
    back.file.clone_from(&spec.file);
    assert_eq!(back, spec);
}
