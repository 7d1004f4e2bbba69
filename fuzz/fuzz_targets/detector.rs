//! Any bytes as a detector's file, and small detectors and the own network with pieces exchanged: an error or a detector that finds boxes of
//! numbers, never a panic.
#![no_main]

use std::path::Path;
use std::sync::OnceLock;

use paid_onnx::OnnxFile;
use paid_vision::ColorImage;
use paid_vision::detect::Detector;

#[path = "../../crates/sense/vision/tests/detectors/mod.rs"]
mod detectors;

const OWN: &[u8] = include_bytes!("../../crates/sense/vision/assets/ball.onnx");

/// Files to begin with; the own one, a thousand times as long to read, comes seldom.
fn seed(number: u8) -> &'static [u8] {
    static SMALL: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    let small = SMALL.get_or_init(detectors::all);
    if number == 255 { OWN } else { &small[usize::from(number) % small.len()] }
}

/// A seed, changed as the rest of the input says: four bytes are the place, what is done there, and with what.
fn changed(input: &[u8]) -> Option<Vec<u8>> {
    let (number, changes) = input.split_first()?;
    let mut bytes = seed(*number).to_vec();
    for change in changes.chunks_exact(4) {
        let [low, high, act, value] = change else { continue };
        let at = usize::from(u16::from_le_bytes([*low, *high])) % bytes.len().max(1);
        match act % 5 {
            0 => bytes.insert(at.min(bytes.len()), *value),
            1 if at < bytes.len() => drop(bytes.remove(at)),
            2 if at < bytes.len() => bytes[at] ^= value,
            3 => bytes.truncate(at.max(1)),
            _ if at < bytes.len() => bytes[at] = *value,
            _ => {}
        }
    }
    Some(bytes)
}

fn look(bytes: Vec<u8>) {
    let Ok(file) = OnnxFile::from_bytes(bytes, Path::new("fuzz.onnx")) else { return };
    let Ok(detector) = Detector::from_file(file, None) else { return };
    let picture = ColorImage::filled(48, 32, [90, 140, 20]);
    for found in detector.with_confidence(0.01).detect(&picture, None).unwrap_or_default() {
        let numbers = found.outline.min.iter().chain(&found.outline.max);
        assert!(found.score.is_finite() && numbers.into_iter().all(|x| x.is_finite()), "{found:?}");
    }
}

libfuzzer_sys::fuzz_target!(
    init: {
        // Panics of the runtime are caught where it is called. One that nobody catches still ends the fuzzing, though without a word.
        std::panic::set_hook(Box::new(|_| ()));
    },
    |input: &[u8]| {
        look(input.to_vec());
        if let Some(bytes) = changed(input) {
            look(bytes);
        }
    }
);
