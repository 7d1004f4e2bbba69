//! The G1s by their `mode_machine`.

use paid_robot::{RobotModel, RobotSpec};

const TOML: &str = include_str!("../../../../configs/robots/g1.toml");

#[test]
fn motors_gains_and_links_of_each_g1_are_those_computed_by_hand() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let before = spec.resolve(&model).expect("resolves");
    // (2 pi 10 Hz)^2 = 3947.8417604; times armature; damping 4 armature 62.8318531.
    let hips = |mode| {
        if mode == 11 || mode == 15 {
            (139.0, 20.0, 99.098_428, 6.308_801)
        } else {
            (88.0, 32.0, 40.179_238, 2.557_890)
        }
    };
    let wrists = |mode| {
        if mode == 13 || mode == 15 {
            (13.4, 27.0, 8.611_032, 0.548_195)
        } else {
            (5.0, 22.0, 16.778_327, 1.068_142)
        }
    };
    for mode in [5, 11, 13, 15, 18] {
        let (other, spec) = spec.as_variant(&model, mode).expect("known");
        let control = spec.resolve(&other).expect("resolves");
        assert_eq!(control.action_scale, before.action_scale, "{mode}");
        for (joint, expected) in [
            ("left_hip_pitch_joint", hips(mode)),
            ("right_hip_pitch_joint", hips(mode)),
            ("left_wrist_yaw_joint", wrists(mode)),
            ("right_wrist_pitch_joint", wrists(mode)),
            ("left_knee_joint", (139.0, 20.0, 99.098_428, 6.308_801)),
        ] {
            let j = other.joint_index(joint).expect("joint");
            let found = (
                other.joints[j].effort_limit,
                control.velocity_limit[j],
                control.stiffness[j],
                control.damping[j],
            );
            let pairs =
                [(found.0, expected.0), (found.1, expected.1), (found.2, expected.2), (found.3, expected.3)];
            assert!(pairs.iter().all(|(a, b)| (a - b).abs() < 2e-6 * b), "{mode} {joint}: {found:?}");
        }
        // Two wrists of 0.684 kg instead of 0.48405 kg.
        let more = other.mass() - model.mass();
        let expected = if mode == 13 || mode == 15 { 2.0 * (0.684 - 0.48405) } else { 0.0 };
        assert!((more - expected).abs() < 1e-9, "{mode}: {more} kg");
        let wrist = other.body_index("left_wrist_yaw_link").expect("body");
        assert_eq!(other.bodies[wrist].pos[0], if expected > 0.0 { 0.051 } else { 0.046 });
    }
}

#[test]
fn a_robot_that_the_file_does_not_name_and_wrong_differences_are_refused() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let error = spec.as_variant(&model, 6).expect_err("a locked waist").to_string();
    assert_eq!(error, "configs/robots/g1.toml: expected a robot of mode_machine 5, 11, 13, 15, 18, found 6");
    for (from, to, expected) in [
        (
            "mode_machines = [11, 15]",
            "mode_machines = [11, 12]",
            "'differences[0].mode_machines': expected numbers of the file's 'mode_machines', found 12",
        ),
        (
            "value = 139.0",
            "value = -1.0",
            "'differences[0].effort_limit[0]': expected a positive torque [N m], found -1",
        ),
        (
            "mass = 0.684",
            "mass = 0.0",
            "'differences[1].links[0].mass': expected a positive mass [kg], found 0",
        ),
        ("value = 0.025101925", "value = nan", "'differences[0].armature[0]'"),
        ("0.00025599, 0.000716332", "0.00025599, -0.1", "xx, yy and zz positive, found -0.1"),
        (
            "body = \"left_wrist_pitch_link\"",
            "body = \"left_wrist_pich_link\"",
            "'differences[1].links': the robot has no body 'left_wrist_pich_link' (did you mean 'left_wrist_pitch_link'?)",
        ),
        ("[[differences.links]]", "wheels = 2\n[[differences.links]]", "unknown field `wheels`"),
    ] {
        assert!(TOML.contains(from), "{from}");
        let read = RobotSpec::from_toml(&TOML.replacen(from, to, 1), "robot.toml");
        let error = read.and_then(|spec| spec.as_variant(&model, 15).map(|_| ())).expect_err(to).to_string();
        assert!(error.contains(expected), "{to}: {error}");
    }
}
