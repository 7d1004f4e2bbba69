//! Any input as npz: an error or a clip, never a panic.
#![no_main]

use std::path::Path;

use paid_robot::{RobotModel, RobotSpec};

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let _ =
        paid_motion::parse_npz(input.to_vec(), Path::new("fuzz.npz"), &RobotModel::g1(), &RobotSpec::g1());
});
