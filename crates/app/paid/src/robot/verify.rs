//! What tests a runtime without a network: replays of its logs, and drills of its stops.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_robot_program::{PlayerArgs, ReplayArgs, at_least_one};
use paid_runtime::log::Course;
use paid_twin::{Fault, draw_course};

use super::VariantArgs;
use crate::failure::Failure;

/// Arguments of `paid robot replay`.
#[derive(Debug, clap::Args)]
pub struct DrawnReplayArgs {
    #[command(flatten)]
    replay: ReplayArgs,
    /// Plot the run, as STEM.png and STEM.svg.
    ///
    /// States, the pelvis from above, its tilt and the estimated ball.
    #[arg(long, value_name = "STEM")]
    plot: Option<PathBuf>,
}

/// Replays a log.
pub fn replay(args: &DrawnReplayArgs) -> Result<ExitCode, Failure> {
    let draw = |course: &Course| match &args.plot {
        Some(stem) => draw_course(course).save(stem).map_err(paid_terminal::Failure::input),
        None => Ok(()),
    };
    Ok(paid_robot_program::replay(&args.replay, draw)?)
}

/// Arguments of `paid robot drill`.
#[derive(Debug, clap::Args)]
pub struct DrillArgs {
    #[command(flatten)]
    player: PlayerArgs,
    #[command(flatten)]
    variant: VariantArgs,
    /// Trials of each fault, at different times.
    #[arg(long, value_name = "N", default_value_t = 20)]
    trials: usize,
    /// Only this fault, such as silence (repeatable).
    #[arg(long = "fault", value_name = "NAME")]
    faults: Vec<Fault>,
}

/// Drills. Exit code 1 if a fault was not damped in time.
pub fn drill(args: &DrillArgs) -> Result<ExitCode, Failure> {
    let trials = at_least_one("--trials", args.trials)?;
    let (player, limits) = args.variant.load(&args.player)?;
    let faults = if args.faults.is_empty() { Fault::ALL.to_vec() } else { args.faults.clone() };
    let report = paid_twin::drill(&player, &limits, &faults, trials, |row| {
        eprintln!("{}: worst {:.0} ms", row.fault.name(), row.worst_ms());
    })?;
    print!("{}", report.table());
    Ok(if report.passed() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
