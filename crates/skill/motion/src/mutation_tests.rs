//! Every reader on thousands of damaged files: an error that names the file, or a clip that is whole; never a panic.
//! `fuzz/` does the same without end.

use std::io::{Cursor, Read, Write};
use std::path::Path;

use paid_testing::damaged;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

use crate::gmr_tests::{LISTS_0, LISTS_4, NUMPY_2, NUMPY_4, NUMPY_5, bytes};
use crate::testing::{model, spec, steady_clip};
use crate::{Clip, MotionError, ReadOptions, parse_csv, parse_gmr, parse_npz, write_csv, write_npz};

/// Counts clips and refusals.
fn judge(name: &str, number: u32, result: Result<Clip, MotionError>, counts: &mut [usize; 2]) {
    match result {
        Ok(clip) => {
            counts[0] += 1;
            let (t, j, b) = (clip.frames, clip.joints, clip.bodies);
            assert!(t >= 2 && clip.fps.is_finite() && clip.fps > 0.0, "{name} {number}");
            assert!(clip.kick_frame.is_none_or(|k| k < t), "{name} {number}");
            assert_eq!((clip.joint_pos.len(), clip.joint_vel.len()), (t * j, t * j), "{name} {number}");
            assert_eq!((clip.body_pos.len(), clip.body_quat.len()), (t * b, t * b), "{name} {number}");
            let numbers = clip.joint_pos.iter().chain(&clip.joint_vel).chain(clip.body_pos.as_flattened());
            let all = numbers.chain(clip.body_quat.as_flattened()).chain(clip.body_lin_vel.as_flattened());
            assert!(all.chain(clip.body_ang_vel.as_flattened()).all(|x| x.is_finite()), "{name} {number}");
        }
        Err(error) => {
            counts[1] += 1;
            let text = error.to_string();
            assert!(text.starts_with("a.") && text.len() < 2000, "{name} {number}: {text}");
        }
    }
}

fn run(name: &str, seed: &[u8], times: u32, read: impl Fn(&[u8]) -> Result<Clip, MotionError>) {
    let mut counts = [0; 2];
    judge(name, 0, read(seed), &mut counts);
    assert_eq!(counts, [1, 0], "{name}: the undamaged file is read");
    for number in 0..times {
        judge(name, number, read(&damaged(seed, number)), &mut counts);
    }
    assert!(counts[1] > times as usize / 20, "{name}: damage is noticed: {counts:?}");
}

#[test]
fn damaged_csv_is_refused_or_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.csv");
    write_csv(&path, &steady_clip(4, 50.0, 1.0)).expect("written");
    let seed = std::fs::read(&path).expect("written");
    run("csv", &seed, 4000, |bytes| {
        let text = String::from_utf8_lossy(bytes);
        parse_csv(&text, Path::new("a.csv"), &model(), &spec(), &ReadOptions::default())
    });
}

#[test]
fn damaged_pickles_are_refused_or_whole() {
    for (name, hex) in
        [("4", NUMPY_4), ("5", NUMPY_5), ("2", NUMPY_2), ("lists 0", LISTS_0), ("lists 4", LISTS_4)]
    {
        run(name, &bytes(hex), 4000, |bytes| {
            parse_gmr(bytes, Path::new("a.pkl"), &model(), &spec(), &ReadOptions::default())
        });
    }
}

/// The archive again, one entry's content damaged, so that its checksum is right.
fn with_damaged_entry(seed: &[u8], number: u32) -> Vec<u8> {
    let mut archive = ZipArchive::new(Cursor::new(seed)).expect("a good archive");
    let mut out = ZipWriter::new(Cursor::new(Vec::new()));
    let victim = number as usize % archive.len();
    for i in 0..archive.len() {
        let mut entry = archive.by_index(i).expect("an entry");
        let name = entry.name().expect("a name").into_owned();
        let mut content = Vec::new();
        entry.read_to_end(&mut content).expect("its content");
        if i == victim {
            content = damaged(&content, number);
        }
        let options = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
        out.start_file(name, options).expect("an entry");
        out.write_all(&content).expect("its content");
    }
    out.finish().expect("an archive").into_inner()
}

#[test]
fn damaged_archives_are_refused_or_whole() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.npz");
    let clip = Clip { kick_frame: Some(1), ..steady_clip(3, 50.0, 1.0) };
    write_npz(&path, &clip, &model(), &spec()).expect("written");
    let seed = std::fs::read(&path).expect("written");
    let read = |bytes: &[u8]| parse_npz(bytes.to_vec(), Path::new("a.npz"), &model(), &spec());
    run("npz", &seed, 2000, read);
    let mut counts = [0; 2];
    for number in 0..2000 {
        judge("npz entries", number, read(&with_damaged_entry(&seed, number)), &mut counts);
    }
    assert!(counts[1] > 500, "{counts:?}");
}
