//! Short files, other units and another axis up, for each reader: one clear error, or a note that says what was recognized.

use std::path::{Path, PathBuf};

use paid_motion::{Points, write_points};
use paid_retarget::{
    HumanMotion, HumanOptions, RetargetError, RetargetOptions, amc_texts, bvh_text, parse_bvh, read_human,
    retarget,
};
use paid_robot::{RobotModel, RobotSpec};
use tempfile::TempDir;

const SHEET: &str = "[joints]\nleft_hip = 'LeftUpLeg'\nleft_knee = 'LeftLeg'\nleft_ankle = 'LeftFoot'\nleft_toe = 'LeftToe'\n\
    left_shoulder = 'LeftArm'\nleft_elbow = 'LeftForeArm'\nleft_wrist = 'LeftHand'\nright_hip = 'RightUpLeg'\n\
    right_knee = 'RightLeg'\nright_ankle = 'RightFoot'\nright_toe = 'RightToe'\nright_shoulder = 'RightArm'\n\
    right_elbow = 'RightForeArm'\nright_wrist = 'RightHand'\n";

/// A player made of numbers, who stands at (0.5, 2) `[m]`.
fn player(frames: usize) -> HumanMotion {
    let mut motion =
        parse_bvh(&crate::common::kick_bvh(frames), Path::new("kick.bvh"), 0.01).expect("a good file");
    motion.pos.iter_mut().for_each(|p| *p = [p[0] + 0.5, p[1] + 2.0, p[2]]);
    motion
}

/// All lengths times `by`.
fn scaled(mut motion: HumanMotion, by: f64) -> HumanMotion {
    motion.pos.as_flattened_mut().iter_mut().for_each(|x| *x *= by);
    motion
}

/// Turned about x, so that what is up is the z axis of a file that is written with y up.
fn with_z_up(mut motion: HumanMotion) -> HumanMotion {
    let turn =
        paid_lanes::Quat::from_axis_angle(paid_lanes::Vec3([1.0, 0.0, 0.0]), std::f64::consts::FRAC_PI_2);
    motion.pos.iter_mut().for_each(|p| *p = turn.rotate(paid_lanes::Vec3(*p)).0);
    motion.quat.iter_mut().for_each(|q| *q = turn.mul(paid_lanes::Quat(*q)).0);
    motion
}

/// The motion as a file of each format.
fn files(motion: &HumanMotion) -> (TempDir, [PathBuf; 3]) {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::write(at("kick.bvh"), bvh_text(motion)).expect("written");
    let [asf, amc] = amc_texts(motion);
    std::fs::write(at("text.asf"), asf).expect("written");
    std::fs::write(at("text.amc"), amc).expect("written");
    let points = Points {
        names: motion.skeleton.bones.iter().map(|b| b.name.clone()).collect(),
        fps: Some(motion.fps),
        frames: motion.frames,
        pos: motion.pos.clone(),
    };
    write_points(&at("points.npz"), &points).expect("written");
    std::fs::write(at("points.toml"), SHEET).expect("written");
    let paths = ["kick.bvh", "text.amc", "points.npz"].map(at);
    (folder, paths)
}

fn read(path: &Path) -> Result<HumanMotion, RetargetError> {
    read_human(path, &HumanOptions { fps: Some(60.0), ..HumanOptions::default() })
}

/// Where the hips are in the first frame.
fn hips(motion: &HumanMotion) -> [f64; 3] {
    let of = |name: &str| motion.skeleton.find(name).map(|i| motion.pos(0)[i]);
    of("Hips").or_else(|| of("hips")).expect("hips")
}

#[test]
fn three_frames_are_refused_by_each_reader_with_the_file_and_what_was_expected() {
    let (_folder, paths) = files(&player(3));
    for path in paths {
        let done = read(&path).and_then(|motion| {
            retarget(&motion, &RobotModel::g1(), &RobotSpec::g1(), &RetargetOptions::default())
        });
        let error = done.expect_err("too short").to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        assert!(error.contains("expected at least 0.5 s"), "{error}");
        assert!(error.ends_with("found 3 frames at 60 Hz"), "{error}");
    }
}

#[test]
fn a_file_that_git_lfs_has_left_as_a_pointer_is_called_so() {
    let (_folder, paths) = files(&player(40));
    for path in paths {
        std::fs::write(&path, "version https://git-lfs.github.com/spec/v1\noid sha256:4d7a\nsize 12\n")
            .expect("written");
        let error = read(&path).expect_err("a pointer").to_string();
        let expected =
            "expected a motion, found a Git LFS pointer, not the file itself; fetch it with `git lfs pull`";
        assert_eq!(error, format!("{}: {expected}", path.display()));
    }
}

#[test]
fn meters_in_a_file_of_centimeters_are_recognized_and_said_by_each_reader() {
    // 0.94 units of hip height, where the formats mean centimeters; points state no unit, so they get centimeters.
    let (_folder, [bvh, amc, _]) = files(&scaled(player(40), 0.01));
    let (_other, [.., points]) = files(&scaled(player(40), 100.0));
    for (path, unit) in [(bvh, "meters"), (amc, "meters"), (points, "centimeters")] {
        let motion = read(&path).expect("a player");
        let note = format!("the lengths were taken for {unit}: a leg has ");
        assert!(motion.notes.iter().any(|n| n.starts_with(&note)), "{}: {:?}", path.display(), motion.notes);
        let found = hips(&motion);
        for (x, expected) in found.iter().zip([0.5, 2.0, 0.94]) {
            // Six decimals of a meter are what the text has.
            assert!((x - expected).abs() < 2e-3, "{}: {found:?}", path.display());
        }
    }
}

#[test]
fn a_unit_that_was_told_and_cannot_be_is_refused() {
    let (_folder, [bvh, ..]) = files(&player(40));
    let told = HumanOptions { unit_m: Some(1.0), ..HumanOptions::default() };
    let error = read_human(&bvh, &told).expect_err("84 m of leg").to_string();
    assert!(
        error.ends_with("unit of length: expected legs of 0.35 to 1.4 m, found 84.0000 m: these look like centimeters (--unit 0.01)"),
        "{error}"
    );
    let right = read_human(&bvh, &HumanOptions { unit_m: Some(0.01), ..HumanOptions::default() });
    assert_eq!(right.expect("centimeters").notes, [""; 0]);
}

#[test]
fn a_leg_that_no_known_unit_makes_a_humans_is_refused_until_the_unit_is_told() {
    // Inches, where the formats mean centimeters: 33 units of leg.
    let (_folder, [bvh, amc, _]) = files(&scaled(player(40), 1.0 / 2.54));
    for path in [bvh, amc] {
        let error = read(&path).expect_err("inches").to_string();
        assert!(error.starts_with(&path.display().to_string()), "{error}");
        assert!(error.contains("unit of length: expected legs of 0.35 to 1.4 m, found 0.33"), "{error}");
        assert!(error.contains(": 33.") && error.ends_with("(--unit)"), "{error}");
        let told = |unit| HumanOptions { fps: Some(60.0), unit_m: Some(unit), ..HumanOptions::default() };
        let motion = read_human(&path, &told(0.0254)).expect("inches");
        assert_eq!(motion.notes, [""; 0], "{}", path.display());
        for (x, expected) in hips(&motion).iter().zip([0.5, 2.0, 0.94]) {
            assert!((x - expected).abs() < 2e-3, "{}: {:?}", path.display(), hips(&motion));
        }
        // A unit that was told and makes nobody's leg.
        let error = read_human(&path, &told(0.2)).expect_err("6.6 m of leg").to_string();
        assert!(error.contains("expected legs of 0.35 to 1.4 m, found 6.6"), "{error}");
    }
}

#[test]
fn a_text_that_is_too_large_is_refused_before_it_is_read() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("long.bvh");
    // Nothing but a length: no disk is filled.
    let file = std::fs::File::create(&path).expect("made");
    file.set_len((1 << 28) + 1).expect("as long as it gets");
    let error = read_human(&path, &HumanOptions::default()).expect_err("too large").to_string();
    assert!(error.contains("long.bvh: expected at most 256 MiB of text, found 257 MiB; cut"), "{error}");
}

#[test]
fn z_up_is_recognized_and_said_by_each_reader() {
    let upright = player(40);
    let (_folder, [bvh, amc, _]) = files(&with_z_up(upright.clone()));
    let (_other, [.., points]) = files(&upright);
    for path in [bvh, amc, points] {
        let motion = read(&path).expect("a player");
        assert_eq!(motion.notes, ["z was taken for up: the trunk points there"], "{}", path.display());
        for (x, expected) in hips(&motion).iter().zip([0.5, 2.0, 0.94]) {
            assert!((x - expected).abs() < 1e-3, "{}: {:?}", path.display(), hips(&motion));
        }
    }
}

#[test]
fn y_up_in_the_usual_unit_needs_no_word() {
    let (_folder, [bvh, amc, _]) = files(&player(40));
    for path in [bvh, amc] {
        assert_eq!(read(&path).expect("a player").notes, [""; 0], "{}", path.display());
    }
}

#[test]
fn a_player_who_lies_on_the_floor_is_not_stood_up() {
    // On the back, head along the file's z axis, hips 0.15 m above the floor.
    let mut lying = with_z_up(player(40));
    let low = lying.pos.iter().map(|p| p[2]).fold(f64::INFINITY, f64::min);
    lying.pos.iter_mut().for_each(|p| p[2] -= low);
    let (_folder, [bvh, amc, _]) = files(&lying);
    for path in [bvh, amc] {
        let motion = read(&path).expect("a player");
        assert_eq!(motion.notes, [""; 0], "{}", path.display());
        let error = retarget(&motion, &RobotModel::g1(), &RobotSpec::g1(), &RetargetOptions::default())
            .expect_err("lying")
            .to_string();
        assert!(
            error.contains("expected a player on the feet") && error.contains("up axis is another"),
            "{error}"
        );
    }
}

#[test]
fn a_frame_rate_beside_that_of_a_bvh_file_takes_its_place_and_is_said() {
    let (_folder, [bvh, ..]) = files(&player(130));
    let at = |fps| {
        read_human(&bvh, &HumanOptions { fps: Some(fps), ..HumanOptions::default() }).expect("a player")
    };
    let rounded = at(60.3);
    assert!((rounded.fps - 60.0).abs() < 0.01 && rounded.notes.is_empty(), "a rounded frame time");
    let other = at(120.0);
    assert_eq!((other.fps, other.notes.len()), (120.0, 1), "{:?}", other.notes);
    assert!(other.notes[0].ends_with("is not used: --fps 120 is"), "{:?}", other.notes);
}

#[test]
fn a_frame_rate_that_cannot_be_is_named() {
    // Hips that bob by 3 cm twice a second.
    let mut bobs = player(130);
    let n = bobs.skeleton.bones.len();
    for (i, p) in bobs.pos.iter_mut().enumerate() {
        p[2] += 0.03 * ((i / n) as f64 / 60.0 * 2.0 * std::f64::consts::TAU).sin();
    }
    let (_folder, [bvh, ..]) = files(&bobs);
    let notes = |fps| {
        read_human(&bvh, &HumanOptions { fps: Some(fps), ..HumanOptions::default() }).expect("a player").notes
    };
    assert_eq!(notes(60.0), [""; 0]);
    let fast = notes(240.0);
    assert!(fast[1].starts_with("at 240.0 frames a second the hips fall with 4.4 times"), "{fast:?}");
    assert!(fast[1].ends_with("a human falls with 1; --fps states another frame rate"), "{fast:?}");
    let slow = notes(15.0);
    let note = "at 15.0 frames a second the fastest foot has 1.3 m/s: little for a kick; --fps states another frame rate";
    assert_eq!(slow[1], note);
}

/// A file of the reported cases, read with a frame rate or none.
fn case(test: &str, file: &str, fps: Option<f64>) -> Option<HumanMotion> {
    let path = paid_testing::shared_data(test, &format!("cases/{file}"))?;
    Some(read_human(&path, &HumanOptions { fps, ..HumanOptions::default() }).expect(file))
}

#[test]
fn reported_files_are_read_as_the_clip_that_they_were_made_of() {
    const TEST: &str = "reported_files_are_read_as_the_clip_that_they_were_made_of";
    let Some(spaces) = case(TEST, "name_with_space.bvh", None) else { return };
    let Some(longer) = case(TEST, "one_row_too_many.bvh", None) else { return };
    assert_eq!(longer.notes, ["the file promises 77 frames and has 78 frames: all are used"]);
    assert_eq!((&spaces.pos, spaces.frames), (&longer.pos, 78));
    let Some(fast) = case(TEST, "wrong_frame_time.bvh", None) else { return };
    assert!(fast.notes[0].starts_with("at 120.0 frames a second the hips fall with "), "{:?}", fast.notes);
    let Some(right) = case(TEST, "wrong_frame_time.bvh", Some(30.0)) else { return };
    assert_eq!(right.notes, ["the file's frame time, \"0.008333\" s, is not used: --fps 30 is"]);
    assert_eq!(right.pos, longer.pos);
}

#[test]
fn a_skeleton_beside_a_bvh_file_is_refused() {
    let (folder, [bvh, ..]) = files(&player(40));
    let options = HumanOptions { skeleton: Some(folder.path().join("text.asf")), ..HumanOptions::default() };
    let error = read_human(&bvh, &options).expect_err("two skeletons").to_string();
    assert!(
        error.starts_with(&format!("{}: expected no --skeleton beside a BVH file", bvh.display())),
        "{error}"
    );
    assert!(error.ends_with("text.asf"), "{error}");
}
