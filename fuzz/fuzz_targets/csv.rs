//! Any input as csv: an error or a clip, never a panic.
#![no_main]

use std::path::Path;

use paid_motion::ReadOptions;
use paid_robot::{RobotModel, RobotSpec};

libfuzzer_sys::fuzz_target!(|input: &str| {
    let _ = paid_motion::parse_csv(
        input,
        Path::new("fuzz.csv"),
        &RobotModel::g1(),
        &RobotSpec::g1(),
        &ReadOptions::default(),
    );
});
