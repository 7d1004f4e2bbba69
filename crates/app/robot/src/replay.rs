//! Replays of logs.

use std::path::PathBuf;
use std::process::ExitCode;
use std::sync::Arc;

use paid_runtime::Player;
use paid_runtime::log::{Course, LogReader};

use crate::args::print_event;
use paid_terminal::Failure;

/// Arguments of `paid robot replay`.
#[derive(Debug, clap::Args)]
pub struct ReplayArgs {
    /// Log of a run.
    log: PathBuf,
    /// Policy, if it has moved since.
    #[arg(long, value_name = "POLICY")]
    policy: Option<PathBuf>,
    /// Folder of motion files, if it has moved since.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Print each transition.
    #[arg(long)]
    events: bool,
    /// Print the processor time of the steps.
    #[arg(long)]
    times: bool,
}

/// Compares a log with what the runtime does today. Exit code 1 if anything differs. `draw` is given how it went.
///
/// # Errors
/// If log, policy or motions cannot be read, or `draw` fails.
pub fn replay(
    args: &ReplayArgs,
    draw: impl FnOnce(&Course) -> Result<(), Failure>,
) -> Result<ExitCode, Failure> {
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
    if let Some(cut) = log.cut_off() {
        eprintln!("note: {cut}; what comes before was used");
    }
    println!("{} steps, {} of them with the policy", found.frames, found.policy_steps);
    if args.times {
        print!("{}", found.times.table());
    }
    draw(&found.course)?;
    match found.difference {
        None => {
            println!("all commands, observations and actions are equal bit for bit");
            Ok(ExitCode::SUCCESS)
        }
        Some((frame, what)) => {
            println!("step {frame}: {what} differs");
            Ok(ExitCode::from(1))
        }
    }
}
