//! What a motion folder accepts and how it refuses the rest.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use tempfile::TempDir;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use crate::testing::{model, spec, steady_clip};
use crate::write::{numbers, text, texts};
use crate::{MotionError, MotionLibrary, read_clip, write_npz};

/// Writes a good 4-frame file except for what `alter` does: it may drop a key or write it otherwise, and then returns true.
fn file_with(dir: &TempDir, alter: impl Fn(&mut ZipWriter<File>, &str) -> bool) -> PathBuf {
    let path = dir.path().join("clip.npz");
    let mut zip = ZipWriter::new(File::create(&path).expect("a temporary folder is writable"));
    let ones = vec![0.5_f32; 64];
    let keys: [(&str, &[u64]); 7] = [
        ("fps", &[1]),
        ("joint_pos", &[4, 2]),
        ("joint_vel", &[4, 2]),
        ("body_pos_w", &[4, 3, 3]),
        ("body_quat_w", &[4, 3, 4]),
        ("body_lin_vel_w", &[4, 3, 3]),
        ("body_ang_vel_w", &[4, 3, 3]),
    ];
    for (key, shape) in keys {
        let len: u64 = shape.iter().product();
        if alter(&mut zip, key) {
            continue;
        } else if key == "fps" {
            numbers(&mut zip, key, shape, &[50_i64]).expect("written");
        } else {
            // Quaternions of four halves are unit.
            numbers(&mut zip, key, shape, &ones[..len as usize]).expect("written");
        }
    }
    if !alter(&mut zip, "kick_leg") {
        text(&mut zip, "kick_leg", "left").expect("written");
    }
    alter(&mut zip, "end");
    zip.finish().expect("written");
    path
}

fn refusal(path: &Path) -> String {
    let error = read_clip(path, &model(), &spec()).expect_err("the file is bad").to_string();
    assert!(error.contains("clip.npz"), "names the file: {error}");
    error
}

fn folder() -> TempDir {
    TempDir::new().expect("a temporary folder")
}

#[test]
fn an_unaltered_file_is_read() {
    let dir = folder();
    let clip = read_clip(&file_with(&dir, |_, _| false), &model(), &spec()).expect("good");
    assert_eq!((clip.frames, clip.fps, clip.kick_leg.index(), clip.license), (4, 50.0, 0, None));
}

#[test]
fn a_written_clip_reads_back_to_single_precision_in_model_order() {
    let dir = folder();
    let clip = steady_clip(20, 50.0, 1.0);
    let path = dir.path().join("steady.npz");
    write_npz(&path, &clip, &model(), &spec()).expect("written");
    let back = read_clip(&path, &model(), &spec()).expect("read");
    for t in 0..20 {
        assert!((back.joint_pos(t)[1] - clip.joint_pos(t)[1]).abs() < 1e-6, "right hip is joint 1");
        assert!((back.body_pos(t)[2][1] - 0.2).abs() < 1e-6, "right foot is body 2");
        assert!((back.body_quat(t)[1][3] - clip.body_quat(t)[1][3]).abs() < 1e-6);
        assert!((back.body_lin_vel(t)[1][0] - clip.body_lin_vel(t)[1][0]).abs() < 1e-6);
    }
    assert_eq!(back.license.as_deref(), Some("CC0"));
    assert_eq!(fs::read_dir(dir.path()).expect("readable").count(), 1, "no temporary file is left");
}

#[test]
fn names_in_the_file_win_over_the_convention() {
    let dir = folder();
    let path = file_with(&dir, |zip, key| match key {
        "joint_pos" => numbers(zip, key, &[4, 2], &[1.0_f64, 2.0, 1.0, 2.0, 1.0, 2.0, 1.0, 2.0]).is_ok(),
        "end" => texts(zip, "joint_names", &[2], &["left_hip".to_owned(), "right_hip".to_owned()]).is_ok(),
        _ => false,
    });
    assert_eq!(read_clip(&path, &model(), &spec()).expect("good").joint_pos(3), [1.0, 2.0]);
    let path = file_with(&dir, |zip, key| {
        key == "end" && texts(zip, "joint_names", &[2], &["left_hip".to_owned(), "tail".to_owned()]).is_ok()
    });
    assert!(refusal(&path).contains("'right_hip' is expected but not found; found: left_hip, tail"));
}

#[test]
fn every_missing_key_is_named() {
    for missing in [
        "fps",
        "joint_pos",
        "joint_vel",
        "body_pos_w",
        "body_quat_w",
        "body_lin_vel_w",
        "body_ang_vel_w",
        "kick_leg",
    ] {
        let dir = folder();
        let error = refusal(&file_with(&dir, |_, key| key == missing));
        assert!(error.contains(&format!("key '{missing}' is missing; found: body_")), "{error}");
    }
}

#[test]
fn a_wrong_shape_is_shown_with_the_right_one() {
    let dir = folder();
    let error = refusal(&file_with(&dir, |zip, key| {
        key == "body_pos_w" && numbers(zip, key, &[4, 2, 3], &[0.0_f32; 24]).is_ok()
    }));
    assert!(error.ends_with("key 'body_pos_w': expected shape [4, 3, 3], found [4, 2, 3]"), "{error}");
}

#[test]
fn numbers_that_are_not_finite_are_located() {
    let dir = folder();
    for bad in [f32::NAN, f32::INFINITY] {
        let mut values = [0.0_f32; 36];
        values[9 + 3 + 2] = bad;
        let error = refusal(&file_with(&dir, |zip, key| {
            key == "body_lin_vel_w" && numbers(zip, key, &[4, 3, 3], &values).is_ok()
        }));
        assert!(error.contains(&format!("expected finite numbers, found {bad} at [1, 1, 2]")), "{error}");
    }
}

#[test]
fn numbers_that_are_too_large_for_a_motion_are_located() {
    let dir = folder();
    for key in ["joint_vel", "body_pos_w", "body_lin_vel_w"] {
        let shape: &[u64] = if key == "joint_vel" { &[4, 2] } else { &[4, 3, 3] };
        let with = |value: f64| {
            let mut values = vec![0.0_f64; if key == "joint_vel" { 8 } else { 36 }];
            values[5] = value;
            file_with(&dir, |zip, k| k == key && numbers(zip, key, shape, &values).is_ok())
        };
        assert!(read_clip(&with(-1e6), &model(), &spec()).is_ok(), "{key}");
        let place = if key == "joint_vel" { "[2, 1]" } else { "[0, 1, 2]" };
        let error = refusal(&with(1e300));
        let expected = format!("key '{key}': expected numbers from -1e6 to 1e6, found 1e300 at {place}");
        assert!(error.ends_with(&expected), "{error}");
    }
}

#[test]
fn a_quaternion_that_is_not_unit_is_located() {
    let dir = folder();
    let mut values = [0.5_f32; 48];
    values[12 * 2 + 4] = 0.0; // frame 2, second body of the file
    let error = refusal(&file_with(&dir, |zip, key| {
        key == "body_quat_w" && numbers(zip, key, &[4, 3, 4], &values).is_ok()
    }));
    assert!(error.contains("expected unit quaternions") && error.ends_with("at [2, 1]"), "{error}");
}

#[test]
fn labels_rates_and_types_are_checked() {
    let dir = folder();
    let error = refusal(&file_with(&dir, |zip, key| key == "kick_leg" && text(zip, key, "middle").is_ok()));
    assert!(error.ends_with("key 'kick_leg': expected 'left' or 'right', found 'middle'"), "{error}");
    let error =
        refusal(&file_with(&dir, |zip, key| key == "fps" && numbers(zip, key, &[1], &[0_i64]).is_ok()));
    assert!(error.contains("key 'fps': expected 1 to 2000 frames a second, found 0"), "{error}");
    let error = refusal(&file_with(&dir, |zip, key| key == "fps" && text(zip, key, "50").is_ok()));
    assert!(error.contains("key 'fps': expected numbers"), "{error}");
    let error =
        refusal(&file_with(&dir, |zip, key| key == "kick_leg" && numbers(zip, key, &[1], &[1_i64]).is_ok()));
    assert!(error.contains("key 'kick_leg': expected text"), "{error}");
    let error = refusal(&file_with(&dir, |zip, key| {
        key == "joint_pos" && numbers(zip, key, &[1, 2], &[0.0_f32; 2]).is_ok()
    }));
    assert!(error.contains("expected at least 2 frames, found shape [1, 2]"), "{error}");
}

#[test]
fn texts_of_no_letters_are_no_more_than_the_file_has_bytes() {
    let dir = folder();
    let header = "{'descr': '<U0', 'fortran_order': False, 'shape': (1000000,), }\n";
    let npy = [&b"\x93NUMPY\x01\0"[..], &(header.len() as u16).to_le_bytes(), header.as_bytes()].concat();
    let error = refusal(&file_with(&dir, |zip, key| {
        key == "kick_leg"
            && zip.start_file("kick_leg.npy".to_owned(), SimpleFileOptions::default()).is_ok()
            && zip.write_all(&npy).is_ok()
    }));
    let expected =
        format!("key 'kick_leg': expected a whole NPY array, found shape [1000000] in {} bytes", npy.len());
    assert!(error.ends_with(&expected), "{error}");
}

#[test]
fn a_file_cut_anywhere_is_refused() {
    let dir = folder();
    let path = file_with(&dir, |_, _| false);
    let whole = fs::read(&path).expect("readable");
    for share in [0, 1, 10, 50, 90, 99] {
        fs::write(&path, &whole[..whole.len() * share / 100]).expect("writable");
        assert!(refusal(&path).contains("expected an NPZ archive"));
    }
}

#[test]
fn a_damaged_byte_never_passes_as_another_motion() {
    let dir = folder();
    let path = file_with(&dir, |_, _| false);
    let good = read_clip(&path, &model(), &spec()).expect("good");
    let whole = fs::read(&path).expect("readable");
    for place in (0..whole.len()).step_by(7) {
        let mut bytes = whole.clone();
        bytes[place] ^= 0x41;
        fs::write(&path, bytes).expect("writable");
        // Bytes that carry no content (times, padding) may pass; content is protected by the archive's checksum.
        if let Ok(clip) = read_clip(&path, &model(), &spec()) {
            assert_eq!(clip, good, "byte {place}");
        }
    }
}

#[test]
fn a_folder_is_read_recursively_in_sorted_order_at_the_control_rate() {
    let dir = folder();
    fs::create_dir(dir.path().join("b")).expect("created");
    for (name, fps) in [("c.npz", 50.0), ("b/z.npz", 100.0), ("a.npz", 25.0)] {
        write_npz(&dir.path().join(name), &steady_clip(11, fps, 0.5), &model(), &spec()).expect("written");
    }
    fs::write(dir.path().join("notes.txt"), "not a motion").expect("written");
    let library = MotionLibrary::load(dir.path(), &model(), &spec(), 50.0).expect("good");
    let found: Vec<_> = library.clips.iter().map(|c| (c.name.as_str(), c.frames, c.fps)).collect();
    assert_eq!(found, [("a", 21, 50.0), ("z", 6, 50.0), ("c", 11, 50.0)]);
    assert_eq!(library.longest(), 21);
}

#[test]
fn missing_and_empty_folders_are_refused() {
    let dir = folder();
    let load = |path: &Path, rate| MotionLibrary::load(path, &model(), &spec(), rate);
    assert!(matches!(load(dir.path(), 50.0), Err(MotionError::Empty { .. })));
    let missing = load(&dir.path().join("nowhere"), 50.0).expect_err("missing");
    assert!(missing.to_string().contains("nowhere"), "{missing}");
    for rate in [f64::NAN, f64::INFINITY, 1e12, 2001.0, 9.9, 0.001, 0.0, -50.0] {
        assert!(matches!(load(dir.path(), rate), Err(MotionError::Rate(_))), "{rate}");
    }
}
