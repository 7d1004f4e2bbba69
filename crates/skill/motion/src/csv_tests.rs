//! What CSV motions keep and how bad ones are refused.

use std::fs;
use std::path::PathBuf;

use paid_lanes::{Quat, Vec3};
use paid_robot::kinematics;
use proptest::prelude::*;
use tempfile::TempDir;

use crate::resample::differentiate;
use crate::testing::{model, spec, steady_clip};
use crate::{Clip, JointOrder, KickLeg, MotionError, ReadOptions, read_motion, write_motion};

/// A clip whose bodies are where its joints put them.
fn clip(bases: &[([f64; 3], [f64; 4])], joints: &[f64], fps: f64) -> Clip {
    let mut clip = steady_clip(bases.len(), fps, 0.0);
    clip.joint_pos = joints.to_vec();
    (clip.body_pos, clip.body_quat) = (Vec::new(), Vec::new());
    for (t, &(pos, quat)) in bases.iter().enumerate() {
        for pose in kinematics::forward::<f64>(&model(), Vec3(pos), Quat(quat), &joints[2 * t..2 * t + 2]) {
            clip.body_pos.push(pose.pos.0);
            clip.body_quat.push(pose.quat.0);
        }
    }
    differentiate(&mut clip, &model());
    clip
}

fn written(text: &str) -> (TempDir, PathBuf) {
    let dir = TempDir::new().expect("a temporary folder");
    let path = dir.path().join("clip.csv");
    fs::write(&path, text).expect("written");
    (dir, path)
}

fn refusal(text: &str) -> String {
    let (_dir, path) = written(text);
    let error = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect_err("bad").to_string();
    assert!(error.contains("clip.csv"), "{error}");
    error
}

const ROW: &str = "0.1,0.2,0.7,0,0,0,1,0.3,-0.4\n";

fn numbers(count: usize) -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.5..1.5_f64, count)
}

proptest! {
    #[test]
    fn a_clip_survives_every_format(
        values in numbers(6 * 9), fps in 10.0..240.0_f64, left in any::<bool>(), kick in 0..6_usize,
    ) {
        let bases: Vec<_> = values.chunks(9).map(|v| {
            let quat = Quat([v[3] + 2.0, v[4], v[5], v[6]]).normalize();
            ([v[0], v[1], v[2]], quat.0)
        }).collect();
        let joints: Vec<f64> = values.chunks(9).flat_map(|v| [v[7], v[8]]).collect();
        let leg = if left { KickLeg::Left } else { KickLeg::Right };
        let clip = Clip { kick_leg: leg, kick_frame: Some(kick), ..clip(&bases, &joints, fps) };
        let dir = TempDir::new().expect("a temporary folder");
        for (name, tolerance) in [("a.csv", 1e-12), ("a.npz", 1e-6)] {
            let path = dir.path().join(name);
            write_motion(&path, &clip, &model(), &spec()).expect("written");
            let back = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect("read");
            prop_assert_eq!((back.frames, back.kick_leg, back.kick_frame), (6, leg, Some(kick)));
            prop_assert_eq!(back.license.as_deref(), Some("CC0"));
            prop_assert!((back.fps - fps).abs() < 1e-12);
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < tolerance * (1.0 + y.abs()));
            prop_assert!(near(&back.joint_pos, &clip.joint_pos));
            prop_assert!(near(back.body_pos.as_flattened(), clip.body_pos.as_flattened()));
            prop_assert!(near(back.body_quat.as_flattened(), clip.body_quat.as_flattened()));
            // Differences over a short step magnify the last digit.
            let rough = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e3 * tolerance * (1.0 + y.abs()));
            prop_assert!(rough(&back.joint_vel, &clip.joint_vel));
            prop_assert!(rough(back.body_lin_vel.as_flattened(), clip.body_lin_vel.as_flattened()));
            prop_assert!(rough(back.body_ang_vel.as_flattened(), clip.body_ang_vel.as_flattened()));
        }
        prop_assert_eq!(fs::read_dir(dir.path()).expect("readable").count(), 2, "no temporary file is left");
    }

    #[test]
    fn no_text_brings_the_reader_down(text in "[-0-9.,#a-z:\n ]{0,200}") {
        let (_dir, path) = written(&text);
        let read = read_motion(&path, &model(), &spec(), &ReadOptions { fps: Some(50.0), ..ReadOptions::default() });
        if let Ok(clip) = read {
            prop_assert!(clip.frames >= 2 && clip.joint_pos.iter().all(|x| x.is_finite()));
        }
    }
}

#[test]
fn a_bare_file_needs_a_frame_rate_and_is_labeled_by_its_faster_foot() {
    let (_dir, path) = written(&[ROW, ROW, "0.1,0.2,0.7,0,0,0,1,0.3,0.4\n"].concat());
    let error = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect_err("no rate");
    assert!(matches!(error, MotionError::Unstated { .. }), "{error}");
    let options = ReadOptions { fps: Some(30.0), ..ReadOptions::default() };
    let clip = read_motion(&path, &model(), &spec(), &options).expect("good");
    assert_eq!((clip.frames, clip.fps, clip.kick_leg, clip.license), (3, 30.0, KickLeg::Right, None));
    assert_eq!(clip.joint_vel[5], 0.8 * 30.0);
}

#[test]
fn the_quaternion_is_read_with_w_last_and_joints_by_their_names() {
    let names = "x,y,z,qx,qy,qz,qw,right_hip,left_hip\n";
    let row = "0,0,1,0,0,0.6,0.8,0.1,0.2\n";
    let (_dir, path) = written(&["# fps: 50\n", names, row, row].concat());
    let clip = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect("good");
    assert_eq!(clip.body_quat[0], [0.8, 0.0, 0.0, 0.6]);
    assert_eq!(clip.joint_pos(0), [0.2, 0.1], "left hip is joint 0");
}

#[test]
fn joints_in_the_policys_order_are_brought_into_the_models() {
    let text = ["# fps: 50\n", ROW, ROW].concat();
    let (_dir, path) = written(&text);
    let asked = ReadOptions { joint_order: Some(JointOrder::Policy), ..ReadOptions::default() };
    // The test robot's files list the right side first.
    let clip = read_motion(&path, &model(), &spec(), &asked).expect("good");
    assert_eq!(clip.joint_pos(0), [-0.4, 0.3]);
    let (_dir, path) = written(&["# joint_order: policy\n", &text].concat());
    assert_eq!(
        read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect("good"),
        Clip { path, ..clip }
    );
}

#[test]
fn faults_are_shown_with_line_and_field() {
    let error = refusal(&["# fps: 50\n", ROW, "0.1,0.2,0.7,0,0,0,1,0.3,oops\n"].concat());
    assert!(error.ends_with("clip.csv:3:9: expected a finite number, found 'oops'"), "{error}");
    let error = refusal(&["# fps: 50\n", ROW, "1,2,3\n"].concat());
    assert!(
        error.contains("clip.csv:3:3: expected 9 numbers") && error.ends_with("found 3 fields"),
        "{error}"
    );
    let error = refusal(&[ROW, "0.1,0.2,0.7,0,0,0,2,0.3,0\n"].concat());
    assert!(error.contains("clip.csv:2:4: expected a unit quaternion"), "{error}");
    let error = refusal(&["# fps: 0\n", ROW, ROW].concat());
    assert!(error.contains("clip.csv:1:1: expected 1 to 2000 frames a second, found 0"), "{error}");
    let error = refusal(&["# fps: 50\n# kick_leg: middle\n", ROW, ROW].concat());
    assert!(error.contains("clip.csv:2:1: expected 'left' or 'right', found 'middle'"), "{error}");
    let error = refusal(&["# fps: 50\n", ROW].concat());
    assert!(error.ends_with("expected at least 2 frames, found 1 frames"), "{error}");
    // Not the frame rate, which it does not state either.
    let error = refusal("");
    assert!(error.ends_with("clip.csv:1:1: expected at least 2 frames, found 0 frames"), "{error}");
    let error = refusal(&["# fps: 50\n# kick_frame: 2\n", ROW, ROW].concat());
    assert!(error.ends_with("clip.csv:2:1: expected a kick frame from 0 to 1, found 2"), "{error}");
    assert!(
        refusal("# fps: 50\nx,y,z,qx,qy,qz,qw,left_hip,tail\n")
            .ends_with("the robot's joints, found 'tail' in column 9")
    );
}

#[test]
fn numbers_that_are_no_motions_are_shown_with_line_and_field() {
    let error = refusal(&["# fps: 50\n", ROW, "0.1,-1e11,0.7,0,0,0,1,0.3,0\n"].concat());
    assert!(error.ends_with("clip.csv:3:2: expected a number from -1e6 to 1e6, found -1e11"), "{error}");
    let rows = "0,0.2,0.7,0,0,0,1,0.3,-0.4\n500000,0.2,0.7,0,0,0,1,0.3,-0.4\n";
    let error = refusal(&["# fps: 50\n", rows].concat());
    // 500 km in a fiftieth of a second.
    assert!(error.contains("clip.csv:2:1: expected speeds up to 1e6 m/s or rad/s, found 2.5e7"), "{error}");
}

#[test]
fn a_given_frame_rate_must_be_the_files_own() {
    let (dir, csv) = written(&["# kick_leg: left\n# fps: 50\n", ROW, ROW].concat());
    let npz = dir.path().join("clip.npz");
    write_motion(&npz, &steady_clip(5, 50.0, 0.0), &model(), &spec()).expect("written");
    for (path, place) in [(csv, "clip.csv:2:1"), (npz, "clip.npz: key 'fps'")] {
        let at = |fps| {
            read_motion(&path, &model(), &spec(), &ReadOptions { fps: Some(fps), ..ReadOptions::default() })
        };
        assert_eq!(at(50.0).expect("the same").fps, 50.0);
        let error = at(60.0).expect_err("another").to_string();
        let expected = "expected no --fps other than the file's 50 frames a second, found --fps 60";
        assert!(error.ends_with(&format!("{place}: {expected}")), "{error}");
    }
}

#[test]
fn an_order_of_joints_for_an_archive_which_has_its_own_is_refused() {
    let dir = TempDir::new().expect("a temporary folder");
    let path = dir.path().join("clip.npz");
    write_motion(&path, &steady_clip(5, 50.0, 0.0), &model(), &spec()).expect("written");
    for order in [JointOrder::Model, JointOrder::Policy] {
        let options = ReadOptions { joint_order: Some(order), ..ReadOptions::default() };
        let error = read_motion(&path, &model(), &spec(), &options).expect_err("its own").to_string();
        let expected = "clip.npz: --joint-order: expected a file that does not state its order (.csv, .pkl), found an NPZ archive, \
                        which has its own";
        assert!(error.ends_with(expected), "{error}");
    }
}

#[test]
fn the_content_decides_before_the_name() {
    let dir = TempDir::new().expect("a temporary folder");
    let (npz, disguised) = (dir.path().join("a.npz"), dir.path().join("a.csv"));
    write_motion(&npz, &steady_clip(5, 50.0, 0.0), &model(), &spec()).expect("written");
    fs::rename(&npz, &disguised).expect("renamed");
    let clip = read_motion(&disguised, &model(), &spec(), &ReadOptions::default()).expect("an archive");
    assert_eq!(clip.frames, 5);
    fs::rename(&disguised, dir.path().join("a.bvh")).expect("renamed");
    assert!(read_motion(&dir.path().join("a.bvh"), &model(), &spec(), &ReadOptions::default()).is_ok());
    fs::write(dir.path().join("b.bvh"), ROW).expect("written");
    let error = read_motion(&dir.path().join("b.bvh"), &model(), &spec(), &ReadOptions::default());
    assert!(matches!(error, Err(MotionError::Extension { .. })));
}

#[test]
fn the_folder_of_a_motion_is_made() {
    let dir = TempDir::new().expect("a temporary folder");
    for name in ["raw/kick.npz", "a/b/kick.csv"] {
        let path = dir.path().join(name);
        write_motion(&path, &steady_clip(5, 50.0, 0.0), &model(), &spec()).expect("written");
        assert!(path.is_file());
    }
    let error = write_motion(&dir.path().join("c/kick.txt"), &steady_clip(5, 50.0, 0.0), &model(), &spec());
    assert!(matches!(error, Err(MotionError::Extension { .. })));
    assert!(!dir.path().join("c").exists(), "nothing is made for a name that is refused");
}

#[test]
fn a_byte_order_mark_is_skipped_and_other_separators_are_called_so() {
    let (_dir, path) = written(&["\u{feff}# fps: 50\n", ROW, ROW].concat());
    let clip = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect("reads");
    assert_eq!((clip.frames, clip.body_pos(0)[0]), (2, [0.1, 0.2, 0.7]));
    for (separator, name) in [(" ", "blanks"), ("\t", "tabs"), (";", "semicolons")] {
        let error = refusal(&["# fps: 50\n", &ROW.replace(',', separator)].concat());
        assert!(error.contains("expected 9 numbers with commas") && error.contains(name), "{error}");
    }
}

#[test]
fn named_columns_say_the_order_of_the_quaternion() {
    let names = "pos_x,pos_y,pos_z,quat_w,quat_x,quat_y,quat_z,right_hip,left_hip\n";
    let (_dir, path) = written(
        &["# fps: 50\n", names, "0.1,0.2,0.7,0.8,0,0,0.6,-0.4,0.3\n", "0.1,0.2,0.7,0.8,0,0,0.6,-0.4,0.3\n"]
            .concat(),
    );
    let clip = read_motion(&path, &model(), &spec(), &ReadOptions::default()).expect("reads");
    assert_eq!(clip.body_quat(0)[0], [0.8, 0.0, 0.0, 0.6]);
    assert_eq!(clip.joint_pos(0), [0.3, -0.4]);
}
