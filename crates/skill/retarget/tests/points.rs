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

/// With the third axis the other way, as Unity has it.
fn left_handed(mut points: Points) -> Points {
    points.pos.iter_mut().for_each(|[.., z]| *z = -*z);
    points
}

#[test]
fn left_handed_axes_are_refused_until_the_toml_says_so() {
    let mirrored = left_handed(positions(&known()));
    let error = through_files(&mirrored, SHEET).expect_err("left-handed");
    assert!(
        error.contains("kick.npz: positions: expected right-handed axes, found left-handed ones: "),
        "{error}"
    );
    assert!(error.contains("write 'left_handed = true' in the TOML, or exchange left and right"), "{error}");
    let said = through_files(&mirrored, &format!("left_handed = true\n{SHEET}")).expect("a person");
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clip = |motion: &HumanMotion| {
        retarget(motion, &model, &spec, &RetargetOptions::default()).expect("a human").clip
    };
    let plain = through_files(&positions(&known()), SHEET).expect("a person");
    for (a, b) in clip(&said).joint_pos.iter().zip(&clip(&plain).joint_pos) {
        assert!((a - b).abs() < 1e-6, "{a} {b}");
    }
    let error = through_files(&positions(&known()), &format!("left_handed = true\n{SHEET}"))
        .expect_err("right-handed");
    assert!(
        error.ends_with("expected no 'left_handed = true' in the TOML, found right-handed axes"),
        "{error}"
    );
    // Names that are exchanged look the same.
    let exchanged = SHEET.replace("'Left", "'_").replace("'Right", "'Left").replace("'_", "'Right");
    let error = through_files(&positions(&known()), &exchanged).expect_err("exchanged");
    assert!(error.contains("exchange left and right there if only the names are wrong"), "{error}");
}

#[test]
fn points_at_zero_are_gaps_and_hips_at_one_place_no_world() {
    let (whole, n) = (positions(&known()), known().skeleton.bones.len());
    let mut gap = whole.clone();
    let toe = gap.names.iter().position(|name| name == "LeftToe").expect("a toe");
    gap.pos[40 * n + toe] = [0.0; 3];
    let error = through_files(&gap, SHEET).expect_err("a gap");
    let expected = "positions: expected no gaps (fill them before), found 0, 0, 0 in frame 40 at 'LeftToe'";
    assert!(error.ends_with(expected), "{error}");
    // What the TOML does not name may be anywhere.
    let mut elsewhere = whole.clone();
    let end = gap.names.iter().position(|name| name == "LeftToe_end").expect("an end");
    elsewhere.pos[40 * n + end] = [0.0; 3];
    assert!(through_files(&elsewhere, SHEET).is_ok());
    // A player who walks, seen from the hips.
    let mut walk = whole;
    for (t, frame) in walk.pos.chunks_exact_mut(n).enumerate() {
        let swing = 30.0 * (0.2 * t as f64).sin();
        for (name, p) in walk.names.iter().zip(frame) {
            let below = if name.contains("Foot") || name.contains("Toe") { swing } else { 0.0 };
            p[0] += if name.starts_with("Left") { below } else { -below };
        }
    }
    let error = through_files(&walk, SHEET).expect_err("no world");
    assert!(
        error.contains("positions: expected positions in one fixed world, with the way of the hips added"),
        "{error}"
    );
    assert!(error.contains("found hips that stay within 0.000 m while the feet go 0."), "{error}");
    let hips = walk.names.iter().position(|name| name == "Hips").expect("hips");
    for frame in walk.pos.chunks_exact_mut(n) {
        let from = frame[hips];
        frame.iter_mut().for_each(|p| *p = [p[0] - from[0], p[1] - from[1], p[2] - from[2]]);
    }
    let error = through_files(&walk, &format!("{SHEET}hips = 'Hips'\n")).expect_err("no world");
    assert!(error.ends_with("found 'Hips' at 0, 0, 0 in every frame"), "{error}");
}

/// A case that was reported, and its error.
fn case(test: &str, file: &str) -> Option<String> {
    let path = paid_testing::shared_data(test, &format!("cases/{file}"))?;
    Some(read_human(&path, &HumanOptions::default()).expect_err(file).to_string())
}

#[test]
fn reported_points_are_refused_with_what_to_do() {
    let Some(error) = case("reported_points_are_refused_with_what_to_do", "left_handed_unity.npz") else {
        return;
    };
    assert!(error.contains("expected right-handed axes, found left-handed ones"), "{error}");
    let Some(error) = case("reported_points_are_refused_with_what_to_do", "gap_zero.npz") else { return };
    assert!(
        error.ends_with("expected no gaps (fill them before), found 0, 0, 0 in frame 40 at 'Toes_L'"),
        "{error}"
    );
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
