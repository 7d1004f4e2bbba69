//! Any input as pickle: an error or a clip, never a panic.
#![no_main]

use std::path::Path;

use paid_motion::ReadOptions;
use paid_robot::{RobotModel, RobotSpec};

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    let _ = paid_motion::parse_gmr(
        input,
        Path::new("fuzz.pkl"),
        &RobotModel::g1(),
        &RobotSpec::g1(),
        &ReadOptions::default(),
    );
});
