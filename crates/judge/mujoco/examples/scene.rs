//! Writes the G1's evaluation scene as MJCF, for MuJoCo's viewer:
//! `cargo run -p paid-mujoco --example scene -- scene.xml`, then open the file with MuJoCo's `simulate`.

use std::process::ExitCode;

use paid_mujoco::{SceneOptions, mjcf_scene};
use paid_robot::{RobotModel, RobotSpec};

fn main() -> ExitCode {
    let Some(file) = std::env::args().nth(1) else {
        eprintln!("usage: scene FILE");
        return ExitCode::from(2);
    };
    let model = RobotModel::g1();
    let written = RobotSpec::g1().resolve(&model).map_err(|e| e.to_string()).and_then(|control| {
        let text = mjcf_scene(&model, &control, &SceneOptions::default());
        std::fs::write(&file, text).map_err(|e| format!("{file}: {e}"))
    });
    match written {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}
