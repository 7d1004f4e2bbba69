//! Writes the golden values that paid-physics' tests compare the engine with: `cargo golden [FILE]`.
//!
//! All from MuJoCo (see `paid_mujoco::reference` for states and layout) and the project's own robot description.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_mujoco::reference::{dynamics, random_state};
use paid_mujoco::{FloorOptions, MUJOCO_VERSION, MujocoSim, SceneOptions};
use paid_physics::{LaneState, Simulator};
use paid_robot::{RobotModel, RobotSpec};
use serde_json::{Value, json};

/// Number of random states.
const STATES: u32 = 32;
/// One in this many states comes with a mass matrix.
const MASS_EVERY: u32 = 8;
/// Seed of the states.
const SEED: u64 = 2026;
/// Duration of the standing trajectory `[s]`, and the time between its samples in control steps.
const STANDING_S: f64 = 0.5;
const SAMPLE_EVERY: usize = 5;

fn state_json(state: &LaneState) -> Value {
    json!({
        "base_pos": state.base_pos, "base_quat": state.base_quat,
        "base_lin_vel": state.base_lin_vel, "base_ang_vel": state.base_ang_vel,
        "joint_pos": state.joint_pos, "joint_vel": state.joint_vel,
    })
}

/// The default pose under PD control from `height` above the ground, on a floor of unit friction, without a ball.
fn standing(model: &RobotModel, spec: &RobotSpec) -> Result<Value, Box<dyn std::error::Error>> {
    let control = spec.resolve(model)?;
    let floor = FloorOptions { friction: [1.0, 0.005, 0.0001], ..FloorOptions::default() };
    let options = SceneOptions { ball: None, goal: None, floor, ..SceneOptions::default() };
    let mut sim = MujocoSim::new(model, &control, &options, 1)?;
    let start = LaneState {
        base_pos: [0.0, 0.0, spec.nominal_height_m],
        joint_pos: control.default_pos.clone(),
        warm_start: Vec::new(),
        ..sim.save_lane(0, 0)
    };
    sim.reset_lane(0, 0, &start);
    sim.refresh(0);
    let mut samples = Vec::new();
    let steps = (STANDING_S / sim.control_dt_s()).round() as usize;
    for step in 1..=steps {
        sim.step(0, &control.default_pos);
        if step % SAMPLE_EVERY == 0 {
            let bodies: Vec<[f64; 3]> = sim.state(0).bodies.iter().map(|b| b.pos.0).collect();
            samples.push(json!({ "time": step as f64 * sim.control_dt_s(), "body_pos": bodies }));
        }
    }
    Ok(json!({ "start": state_json(&start), "floor_friction": floor.friction[0], "samples": samples }))
}

fn golden() -> Result<Value, Box<dyn std::error::Error>> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let control = spec.resolve(&model)?;
    let options = SceneOptions { ball: None, goal: None, ..SceneOptions::default() };
    let mut sim = MujocoSim::new(&model, &control, &options, 1)?;
    let mut states = Vec::new();
    for index in 0..STATES {
        let at = random_state(&model, SEED, index);
        let d = dynamics(&mut sim, 0, &at);
        let mut entry = state_json(&at.state);
        entry["torque"] = json!(at.torque);
        entry["acceleration"] = json!(d.acceleration);
        entry["bias"] = json!(d.bias);
        if index % MASS_EVERY == 0 {
            let lower: Vec<&[f64]> = d.mass.iter().enumerate().map(|(r, row)| &row[..=r]).collect();
            entry["mass_lower"] = json!(lower);
        }
        states.push(entry);
    }
    Ok(json!({
        "note": "Written by `cargo golden` from the project's own robot description; do not edit. Generalized vectors: base \
                 origin (world axes), base rotation (world axes), joints in model order. SI units.",
        "mujoco": MUJOCO_VERSION,
        "robot": model.name,
        "states": states,
        "standing": standing(&model, &spec)?,
    }))
}

fn main() -> ExitCode {
    let default = concat!(env!("CARGO_MANIFEST_DIR"), "/../../base/physics/tests/golden/mujoco.json");
    let file = std::env::args().nth(1).map_or_else(|| PathBuf::from(default), PathBuf::from);
    let written = golden().and_then(|value| {
        // One line a state keeps differences readable.
        let text = value.to_string().replace("},{\"acceleration\"", "},\n{\"acceleration\"") + "\n";
        let partial = file.with_extension("tmp");
        std::fs::write(&partial, text)?;
        std::fs::rename(&partial, &file)?;
        Ok(())
    });
    match written {
        Ok(()) => {
            println!("{}", file.display());
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("error: {}: {error}", file.display());
            ExitCode::FAILURE
        }
    }
}
