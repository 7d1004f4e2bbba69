//! What tests a runtime without a network: replays of its logs, and drills of its stops.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use paid_runtime::Player;
use paid_runtime::log::LogReader;
use paid_twin::Fault;

use super::{PlayerArgs, at_least_one, print_event};
use crate::failure::Failure;

/// Arguments of `paid robot replay`.
#[derive(Debug, clap::Args)]
pub struct ReplayArgs {
    /// The log.
    log: PathBuf,
    /// The policy, if it is no longer where it was.
    #[arg(long, value_name = "RUN|FILE")]
    policy: Option<PathBuf>,
    /// The motions, if they are no longer where they were.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Print every transition.
    #[arg(long)]
    events: bool,
    /// Print how long the steps took, in processor time.
    #[arg(long)]
    times: bool,
    /// Draw how it went, as STEM.png and STEM.svg: states, the pelvis from above, its tilt, the ball as it was believed.
    #[arg(long, value_name = "STEM")]
    plot: Option<PathBuf>,
}

/// Compares a log with what the runtime does today. Exit code 1 if anything differs.
pub fn replay(args: &ReplayArgs) -> Result<ExitCode, Failure> {
    let mut log = LogReader::open(&args.log)?;
    if let Some(policy) = &args.policy {
        log.header.player.policy.clone_from(policy);
    }
    if args.motions.is_some() {
        log.header.player.motions.clone_from(&args.motions);
    }
    let player = Arc::new(Player::load(&log.header.player)?);
    if args.events {
        let mut reader = LogReader::open(&args.log)?;
        while let Some(frame) = reader.next_frame()? {
            for event in frame.events {
                print_event(&event);
            }
        }
    }
    let found = paid_runtime::log::replay(&mut log, &player)?;
    println!("{} steps, {} of them with the policy", found.frames, found.policy_steps);
    if args.times {
        print!("{}", found.times.table());
    }
    if let Some(stem) = &args.plot {
        paid_twin::draw_course(&found.course).save(stem)?;
    }
    match found.difference {
        None => {
            println!("every command, observation and action came out bit for bit");
            Ok(ExitCode::SUCCESS)
        }
        Some((frame, what)) => {
            println!("step {frame}: {what} came out otherwise");
            Ok(ExitCode::from(1))
        }
    }
}

/// Arguments of `paid robot drill`.
#[derive(Debug, clap::Args)]
pub struct DrillArgs {
    #[command(flatten)]
    player: PlayerArgs,
    /// Trials of each fault, at different moments.
    #[arg(long, value_name = "N", default_value_t = 20)]
    trials: usize,
    /// Drill this fault only (repeatable), such as silence.
    #[arg(long = "fault", value_name = "NAME")]
    faults: Vec<Fault>,
}

/// Drills. Exit code 1 if a fault was not damped in time.
pub fn drill(args: &DrillArgs) -> Result<ExitCode, Failure> {
    let trials = at_least_one("--trials", args.trials)?;
    let (player, limits) = args.player.load()?;
    let faults = if args.faults.is_empty() { Fault::ALL.to_vec() } else { args.faults.clone() };
    let report = paid_twin::drill(&player, &limits, &faults, trials, |row| {
        eprintln!("{}: worst {:.0} ms", row.fault.name(), row.worst_ms());
    })?;
    print!("{}", report.table());
    Ok(if report.passed() { ExitCode::SUCCESS } else { ExitCode::from(1) })
}
