//! Damaged detector files: refused with what was expected and found, or a detector with finite boxes; never a panic.
//! `PAID_MUTATIONS=10000000` makes this as long as you like, and `fuzz/` does the same without end.

mod detectors;

use std::path::Path;

use paid_onnx::OnnxFile;
use paid_testing::damaged;
use paid_vision::ColorImage;
use paid_vision::detect::{Detector, Kind};

/// Reads a file and lets it look at an image; `true` if it could.
fn read(bytes: Vec<u8>, what: &str) -> bool {
    let picture = ColorImage::filled(48, 32, [90, 140, 20]);
    let looked = OnnxFile::from_bytes(bytes, Path::new("a.onnx"))
        .map_err(Into::into)
        .and_then(|file| Detector::from_file(file, None))
        .and_then(|detector| detector.with_confidence(0.01).detect(&picture, None));
    match looked {
        Ok(found) => {
            let sound = |d: &paid_vision::detect::Detection| {
                d.score.is_finite() && d.outline.min.iter().chain(&d.outline.max).all(|x| x.is_finite())
            };
            assert!(found.iter().all(sound), "{what}: {found:?}");
            true
        }
        Err(error) => {
            let error = error.to_string();
            assert!(error.starts_with("a.onnx: ") && error.len() < 20_000, "{what}: {error}");
            false
        }
    }
}

#[test]
fn the_undamaged_detectors_are_read_and_find() {
    let kinds = [
        Kind::YoloV8 { classes: 2, masks: false },
        Kind::YoloV8 { classes: 1, masks: true },
        Kind::YoloX { classes: 1 },
    ];
    for (bytes, kind) in detectors::all().into_iter().zip(kinds) {
        let file = OnnxFile::from_bytes(bytes, Path::new("a.onnx")).expect("a model");
        let detector = Detector::from_file(file, None).expect("a detector").with_confidence(0.01);
        assert_eq!(detector.kind(), kind);
        detector.detect(&ColorImage::filled(48, 32, [90, 140, 20]), None).expect("it looks");
    }
}

#[test]
fn damaged_detectors_are_refused_or_look() {
    let times: u32 =
        std::env::var("PAID_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(30_000);
    for (k, seed) in detectors::all().iter().enumerate() {
        let share = times / 3;
        let count =
            (0..share).filter(|number| read(damaged(seed, *number), &format!("{k} {number}"))).count();
        println!("detector {k}: {count} read, {} refused", share as usize - count);
        assert!(count > share as usize / 100 && count < share as usize, "{k}: {count} of {share} were read");
    }
}

#[test]
fn the_own_network_with_damage_is_refused_or_looks() {
    let own = include_bytes!("../assets/ball.onnx");
    let times: u32 =
        std::env::var("PAID_MUTATIONS").ok().and_then(|text| text.parse().ok()).unwrap_or(30_000);
    let share = times / 300;
    let count = (0..share).filter(|number| read(damaged(own, *number), &format!("{number}"))).count();
    println!("the project's network: {count} read of {share}");
    assert!(read(own.to_vec(), "undamaged"));
}
