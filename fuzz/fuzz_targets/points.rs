//! Any text as the description of a skeleton of points, and any bytes as the points: an error or a motion, never a panic.
#![no_main]

use std::path::Path;

use paid_motion::Points;
use paid_retarget::{HumanOptions, motion_of_points, parse_skeleton};

const SHEET: &str = "[joints]\nleft_hip='a'\nleft_knee='b'\nleft_ankle='c'\nleft_toe='d'\nleft_shoulder='e'\nleft_elbow='f'\nleft_wrist='g'\n\
    right_hip='h'\nright_knee='i'\nright_ankle='j'\nright_toe='k'\nright_shoulder='l'\nright_elbow='m'\nright_wrist='n'\n";

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let (sheet, file) = (Path::new("fuzz.toml"), Path::new("fuzz.npz"));
    // The archive: its check sums keep most of what is tried out.
    let _ = paid_motion::parse_points(input.to_vec(), file);
    // The sheet: a text up to the first byte 0, behind a whole one or alone; what follows are the points, as numbers.
    let end = input.iter().position(|byte| *byte == 0).unwrap_or(input.len());
    let text = String::from_utf8_lossy(&input[..end]);
    let _ = parse_skeleton(&text, sheet);
    let Ok(skeleton) = parse_skeleton(&format!("{text}\n{SHEET}"), sheet) else { return };
    let numbers: Vec<f64> = input[end..]
        .chunks_exact(4)
        .map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]])))
        .filter(|x| x.is_finite())
        .collect();
    let (pos, _) = numbers.as_chunks::<3>();
    let frames = pos.len() / 14;
    if frames < 2 {
        return;
    }
    let points = Points {
        names: ('a'..='n').map(String::from).collect(),
        fps: Some(2.0),
        frames,
        pos: pos[..frames * 14].to_vec(),
    };
    if let Ok(motion) = motion_of_points(file, &points, &skeleton, &HumanOptions::default()) {
        assert_eq!(motion.frames, frames);
        assert!(motion.quat.as_flattened().iter().all(|x| x.is_finite()));
    }
});
