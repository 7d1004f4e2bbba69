//! Positions of points of a known motion: the robot does what it does for the motion itself.

use std::path::Path;

use paid_motion::{Points, write_points};
use paid_retarget::{HumanMotion, HumanOptions, RetargetOptions, parse_bvh, read_human, retarget};
use paid_robot::{RobotModel, RobotSpec};

/// Largest difference of a joint angle `[rad]`.
const TOLERANCE: f64 = 0.03;

const SHEET: &str = "[joints]\nleft_hip = 'LeftUpLeg'\nleft_knee = 'LeftLeg'\nleft_ankle = 'LeftFoot'\nleft_toe = 'LeftToe'\n\
    left_shoulder = 'LeftArm'\nleft_elbow = 'LeftForeArm'\nleft_wrist = 'LeftHand'\nright_hip = 'RightUpLeg'\n\
    right_knee = 'RightLeg'\nright_ankle = 'RightFoot'\nright_toe = 'RightToe'\nright_shoulder = 'RightArm'\n\
    right_elbow = 'RightForeArm'\nright_wrist = 'RightHand'\n";

/// A human made of numbers, with all orientations.
fn known() -> HumanMotion {
    parse_bvh(&crate::common::kick_bvh(130), Path::new("kick.bvh"), 0.01).expect("a good file")
}

/// Its positions alone, with y up, in centimeters.
fn positions(of: &HumanMotion) -> Points {
    Points {
        names: of.skeleton.bones.iter().map(|b| b.name.clone()).collect(),
        fps: Some(of.fps),
        frames: of.frames,
        pos: of.pos.iter().map(|[x, y, z]| [100.0 * x, 100.0 * z, -100.0 * y]).collect(),
    }
}

fn through_files(points: &Points, sheet: &str) -> Result<HumanMotion, String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kick.npz");
    write_points(&path, points).expect("writes");
    std::fs::write(folder.path().join("kick.toml"), sheet).expect("writes");
    read_human(&path, &HumanOptions::default()).map_err(|e| e.to_string())
}

#[test]
fn positions_give_the_joint_angles_of_the_motion_that_they_are_of() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let from_points = through_files(&positions(&known()), SHEET).expect("a person");
    assert_eq!(from_points.notes.len(), 2, "{:?}", from_points.notes);
    let options = RetargetOptions::default();
    let found = retarget(&from_points, &model, &spec, &options).expect("a human");
    let expected = retarget(&known(), &model, &spec, &options).expect("a human");
    assert_eq!((found.report.naming, found.clip.frames), ("points", expected.clip.frames));
    assert_eq!(found.clip.kick_leg, expected.clip.kick_leg);
    let mut moved: f64 = 0.0;
    for (i, (a, b)) in found.clip.joint_pos.iter().zip(&expected.clip.joint_pos).enumerate() {
        let joint = &model.joints[i % model.joints.len()].name;
        assert!((a - b).abs() < TOLERANCE, "frame {}, {joint}: {a} {b}", i / model.joints.len());
        moved = moved.max((b - expected.clip.joint_pos[i % model.joints.len()]).abs());
    }
    assert!(moved > 0.5, "a kick, not a stand: {moved}");
}

#[test]
fn a_player_who_lies_and_a_part_that_never_ends_are_refused() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let refusal = |motion: &HumanMotion| {
        retarget(motion, &model, &spec, &RetargetOptions::default()).expect_err("refused").to_string()
    };
    // The file says that z is up; it is y.
    let lying = through_files(&positions(&known()), &format!("up = 'z'\n{SHEET}")).expect("a person");
    let error = refusal(&lying);
    assert!(
        error.contains("expected a player on the feet, found a trunk that is 90 degrees off upright"),
        "{error}"
    );
    let mut long = known();
    long.fps = 0.012;
    assert_eq!(
        refusal(&long),
        "part of the motion: expected a part of the motion of at most 300 s; name the seconds around the kick, found 10750 s of kick.bvh"
    );
}

#[test]
fn a_missing_description_and_a_missing_limb_are_named() {
    let points = positions(&known());
    let error = through_files(&points, &SHEET.replace("left_knee = 'LeftLeg'\n", "")).expect_err("refused");
    assert!(
        error.contains("kick.toml: joints: expected 'left_knee', a limb that the robot needs"),
        "{error}"
    );
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kick.npz");
    write_points(&path, &points).expect("writes");
    let error = read_human(&path, &HumanOptions::default()).expect_err("refused").to_string();
    assert!(
        error.contains("kick.npz: expected the skeleton of this motion") && error.ends_with("found none"),
        "{error}"
    );
}
