//! `paid eval impacts`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::results::to_json;
use paid_eval::scene::{Engines, ScenePreset};
use paid_files::write_whole;
use paid_lab::impacts::{self, ImpactOptions};
use paid_play::load_robot;
use paid_task::TaskPreset;

use super::Output;
use super::engine::{EngineArgs, positive};
use crate::failure::Failure;

/// Arguments of `paid eval impacts`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Robot: built in, or a robot file.
    #[arg(long, default_value = "g1")]
    robot: String,
    /// Impacts.
    #[arg(long, default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    trials: u32,
    /// Seed of the impacts.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Physics step of the built-in engine [s].
    #[arg(long, value_name = "S", default_value = "0.005", value_parser = positive)]
    builtin_dt: f64,
    #[command(flatten)]
    engine: EngineArgs,
    #[command(flatten)]
    output: Output,
}

/// Throws the ball in both engines and compares.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    Engines::Both.check()?;
    args.output.prepare()?;
    let (robot, spec) = load_robot(&args.robot).map_err(Failure::input)?;
    let mut task = TaskPreset::builtin("paper_stage2").map_err(Failure::input)?;
    let options = ImpactOptions {
        trials: args.trials as usize,
        seed: args.seed,
        physics_dt_s: args.builtin_dt,
        scene: args.engine.spec().resolve(&mut task, ScenePreset::Paper)?,
    };
    let report = impacts::evaluate(&robot, &spec, &options)?;
    let json = to_json(&report)?;
    args.output.print(&report.table(), &json);
    args.output.write(|out| {
        let file = |name: &str| -> PathBuf { out.join(name) };
        write_whole(&file("impacts.json"), json.as_bytes())?;
        Ok(write_whole(&file("impacts.txt"), report.table().as_bytes())?)
    })?;
    Ok(ExitCode::SUCCESS)
}
