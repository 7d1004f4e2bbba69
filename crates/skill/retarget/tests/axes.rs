//! Bones of other names and axes: the robot does what it does for the same motion in known ones.

use std::path::Path;

use paid_lanes::Quat;
use paid_retarget::{
    HumanMotion, HumanOptions, RetargetError, RetargetOptions, Retargeted, bvh_text, parse_bvh, read_human,
    retarget,
};
use paid_robot::{RobotModel, RobotSpec};

/// A human made of numbers, in LAFAN1's names and axes.
fn known() -> HumanMotion {
    parse_bvh(&crate::common::kick_bvh(130), Path::new("kick.bvh"), 0.01).expect("a good file")
}

/// Names of the same bones by other programs, and what stands before each in the file.
const NAMES: [(&str, [&str; 16]); 5] = [
    (
        "mixamorig:",
        [
            "Hips",
            "LeftUpLeg",
            "LeftLeg",
            "LeftFoot",
            "LeftToeBase",
            "RightUpLeg",
            "RightLeg",
            "RightFoot",
            "RightToeBase",
            "Spine2",
            "LeftArm",
            "LeftForeArm",
            "LeftHand",
            "RightArm",
            "RightForeArm",
            "RightHand",
        ],
    ),
    (
        "",
        [
            "Hips",
            "LeftThigh",
            "LeftShin",
            "LeftFoot",
            "LeftToe",
            "RightThigh",
            "RightShin",
            "RightFoot",
            "RightToe",
            "Spine4",
            "LeftArm",
            "LeftForeArm",
            "LeftHand",
            "RightArm",
            "RightForeArm",
            "RightHand",
        ],
    ),
    (
        "Bip001 ",
        [
            "Pelvis",
            "L Thigh",
            "L Calf",
            "L Foot",
            "L Toe0",
            "R Thigh",
            "R Calf",
            "R Foot",
            "R Toe0",
            "Spine2",
            "L UpperArm",
            "L Forearm",
            "L Hand",
            "R UpperArm",
            "R Forearm",
            "R Hand",
        ],
    ),
    (
        "",
        [
            "Pelvis",
            "L_Hip",
            "L_Knee",
            "L_Ankle",
            "L_Foot",
            "R_Hip",
            "R_Knee",
            "R_Ankle",
            "R_Foot",
            "Spine3",
            "L_Shoulder",
            "L_Elbow",
            "L_Wrist",
            "R_Shoulder",
            "R_Elbow",
            "R_Wrist",
        ],
    ),
    (
        "DEF-",
        [
            "pelvis",
            "thigh.L",
            "calf.L",
            "foot.L",
            "ball.L",
            "thigh.R",
            "calf.R",
            "foot.R",
            "ball.R",
            "spine_03",
            "upperarm.L",
            "lowerarm.L",
            "hand.L",
            "upperarm.R",
            "lowerarm.R",
            "hand.R",
        ],
    ),
];

/// The motion with bone axes that are turned by `turn` of each bone's index.
fn with_axes(mut motion: HumanMotion, turn: impl Fn(usize) -> Quat<f64>) -> HumanMotion {
    let n = motion.skeleton.bones.len();
    for (i, q) in motion.quat.iter_mut().enumerate() {
        *q = Quat(*q).mul(turn(i % n)).normalize().0;
    }
    motion
}

/// A turn that is another for each bone.
fn any_turn(i: usize) -> Quat<f64> {
    let k = 1.0 + i as f64;
    Quat([(1.3 * k).sin(), (2.1 * k).cos(), (0.7 * k).sin(), (3.3 * k).cos()]).normalize()
}

/// Through a BVH file.
fn read_back(motion: &HumanMotion) -> HumanMotion {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("kick.bvh");
    std::fs::write(&path, bvh_text(motion)).expect("written");
    read_human(&path, &HumanOptions::default()).expect("a player")
}

fn brought(motion: &HumanMotion) -> Result<Retargeted, RetargetError> {
    retarget(motion, &RobotModel::g1(), &RobotSpec::g1(), &RetargetOptions::default())
}

fn retargeted(motion: &HumanMotion) -> Retargeted {
    brought(motion).expect("a human")
}

fn refusal(motion: &HumanMotion) -> String {
    brought(motion).expect_err("refused").to_string()
}

/// Largest difference of a joint angle `[rad]`.
fn apart(a: &Retargeted, b: &Retargeted) -> f64 {
    let pairs = a.clip.joint_pos.iter().zip(&b.clip.joint_pos);
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn names_and_axes_of_any_program_give_the_same_robot() {
    let expected = retargeted(&known());
    for (before, names) in NAMES {
        let mut motion = with_axes(known(), any_turn);
        let bones = motion.skeleton.bones.iter_mut().filter(|bone| !bone.name.ends_with("_end"));
        bones.zip(names).for_each(|(bone, name)| bone.name = format!("{before}{name}"));
        let back = read_back(&motion);
        let note = "the bones have names that were recognized and axes that were derived from the motion";
        assert_eq!(back.notes, [note]);
        let found = retargeted(&back);
        assert_eq!(expected.clip.kick_leg, found.clip.kick_leg);
        assert!(apart(&found, &expected) < 1e-5, "{before}: {}", apart(&found, &expected));
    }
}

#[test]
fn other_axes_under_lafans_names_are_seen_and_said() {
    let expected = retargeted(&known());
    let back = read_back(&with_axes(known(), any_turn));
    assert_eq!(back.notes, ["the bones have the names of LAFAN1 and axes that were derived from the motion"]);
    assert!(apart(&retargeted(&back), &expected) < 1e-5);
    // Axes that are a little off, as a foot's bone is in some files, stay LAFAN1's.
    let little = Quat([0.995, 0.1, 0.0, 0.0]).normalize();
    assert_eq!(read_back(&with_axes(known(), |_| little)).notes, [""; 0]);
}

#[test]
fn other_names_may_have_lafans_axes() {
    let mut motion = known();
    let bones = motion.skeleton.bones.iter_mut().filter(|bone| !bone.name.ends_with("_end"));
    bones.zip(NAMES[0].1).for_each(|(bone, name)| name.clone_into(&mut bone.name));
    let back = read_back(&motion);
    assert_eq!(back.notes, ["the bones have names that were recognized and the axes of LAFAN1"]);
    assert!(apart(&retargeted(&back), &retargeted(&known())) < 1e-5);
}

#[test]
fn a_robot_far_from_the_human_is_refused() {
    // Bones that spin as no human's do.
    let mut motion = known();
    for (i, q) in motion.quat.iter_mut().enumerate() {
        *q = any_turn(i * i).0;
    }
    let error = refusal(&motion);
    assert!(
        error.starts_with(
            "kick.bvh: expected a robot within 150 mm and 0.5 rad of the scaled human on average, found "
        ),
        "{error}"
    );
    assert!(error.contains(" rad at '") && error.contains("the axes of the bones"), "{error}");
}

#[test]
fn exchanged_sides_and_toes_without_a_length_are_refused() {
    let mut motion = known();
    for bone in &mut motion.skeleton.bones {
        let name = bone.name.replace("Left", "_").replace("Right", "Left");
        bone.name = name.replace('_', "Right");
    }
    motion.skeleton.bones.iter_mut().for_each(|bone| bone.name = bone.name.replace("Rightend", "_end"));
    let error = refusal(&motion);
    assert_eq!(
        error,
        "kick.bvh: bones: expected the left leg on the left, found left and right exchanged, or left-handed axes: the toes point backward"
    );
    let mut motion = with_axes(known(), any_turn);
    let at = |name: &str| motion.skeleton.find(name).expect("a bone");
    let (n, ankle, toe) = (motion.skeleton.bones.len(), at("LeftFoot"), at("LeftToe"));
    motion.skeleton.bones[ankle].name = "L Foot".to_owned();
    motion.pos.chunks_exact_mut(n).for_each(|frame| frame[toe] = frame[ankle]);
    let error = refusal(&motion);
    assert_eq!(
        error,
        "kick.bvh: L Foot: expected a line of 1 cm or more to the next joint, to see its axes, found less"
    );
}

/// A file of the shared data, read; `None`: the test is skipped.
fn shared(test: &str, file: &str) -> Option<HumanMotion> {
    let path = paid_testing::shared_data(test, file)?;
    Some(read_human(&path, &HumanOptions::default()).expect(file))
}

#[test]
fn a_clip_under_lafans_names_gives_what_it_gives_under_its_own() {
    let Some(motion) = shared(
        "a_clip_under_lafans_names_gives_what_it_gives_under_its_own",
        "cases/bandai_with_lafan_names.bvh",
    ) else {
        return;
    };
    let note = "the bones have the names of LAFAN1 and the axes of Bandai-Namco-Research-Motiondataset";
    assert_eq!(motion.notes, [note]);
    let report = retargeted(&motion).report;
    assert!((report.position_error_m - 0.0925).abs() < 5e-5, "{report:?}");
    assert!((report.rotation_error - 0.149).abs() < 5e-4, "{report:?}");
}

#[test]
fn a_real_kick_with_other_axes_is_the_same_kick() {
    const TEST: &str = "a_real_kick_with_other_axes_is_the_same_kick";
    for file in ["data/mocap/bandai/dataset-1_kick_normal_001.bvh", "data/mocap/cmu/10_03.amc"] {
        let Some(motion) = shared(TEST, file) else { return };
        let (expected, found) = (retargeted(&motion), retargeted(&read_back(&with_axes(motion, any_turn))));
        assert_eq!(found.clip.kick_leg, expected.clip.kick_leg);
        assert!(
            found.report.position_error_m < 0.1 && found.report.rotation_error < 0.15,
            "{:?}",
            found.report
        );
        // Legs and waist; arms follow their own hinges instead of the table's pose.
        for j in 0..15 {
            let pairs = found
                .clip
                .joint_pos
                .iter()
                .skip(j)
                .step_by(29)
                .zip(expected.clip.joint_pos.iter().skip(j).step_by(29));
            let off = pairs.map(|(a, b)| (a - b).abs()).sum::<f64>() / expected.clip.frames as f64;
            assert!(off < 0.25, "{file}, joint {j}: {off} rad on average");
        }
    }
}
