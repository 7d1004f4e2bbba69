//! `paid robot`: a policy on a G1, and a simulated G1 on the robot's DDS topics.

mod lag;
mod mirror;
mod offline;
mod serve;
mod verify;
mod watch;

use std::process::ExitCode;
use std::sync::Arc;

use clap::Subcommand;
use paid_robot_program::{CheckArgs, PlayerArgs, RunArgs, check};
use paid_runtime::{DeployError, Limits, Player};
use paid_twin::TwinError;

use crate::failure::Failure;
use crate::live::LiveArgs;
use mirror::Mirror;

/// Arguments of `paid robot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Simulate a G1: on the network in real time, or in lockstep with the runtime.
    Sim(offline::SimArgs),
    /// Run a policy on the robot: damping, stand up, wait for a ball, kick, settle.
    Run(WatchedRunArgs),
    /// Check the robot's states, rates and joints. Sends no commands.
    Check(CheckArgs),
    /// Run a log through the runtime again, and compare the results bit for bit.
    Replay(verify::DrawnReplayArgs),
    /// Measure in logs how late the joints follow their targets.
    Lag(lag::LagArgs),
    /// Inject each fault into a simulated G1 and measure how soon it is damped.
    Drill(verify::DrillArgs),
}

/// Which G1 is simulated.
#[derive(Debug, clap::Args)]
struct VariantArgs {
    /// G1 to simulate, by the mode_machine that it reports: 5, 11, 13, 15 or 18.
    #[arg(long, value_name = "N", default_value_t = 5)]
    mode_machine: u8,
}

impl VariantArgs {
    /// Player of that robot, and limits.
    fn load(&self, player: &PlayerArgs) -> Result<(Arc<Player>, Limits), Failure> {
        let (player, limits) = player.load()?;
        let player = player
            .as_variant(self.mode_machine)
            .map_err(|error| Failure::input(format!("--mode-machine: {error}")))?;
        Ok((Arc::new(player), limits))
    }
}

/// Arguments of `paid robot run`.
#[derive(Debug, clap::Args)]
struct WatchedRunArgs {
    #[command(flatten)]
    run: RunArgs,
    #[command(flatten)]
    live: LiveArgs,
}

/// Runs it.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Sim(args) => offline::sim(&args),
        Command::Run(WatchedRunArgs { run, live }) => {
            let watch = |player: &_, stop: &_| Mirror::open(&live, &run.player, player, stop);
            Ok(paid_robot_program::run(&run, watch)?)
        }
        Command::Check(args) => Ok(check(&args)?),
        Command::Replay(args) => verify::replay(&args),
        Command::Lag(args) => lag::lag(&args),
        Command::Drill(args) => verify::drill(&args),
    }
}

impl From<TwinError> for Failure {
    fn from(error: TwinError) -> Self {
        Self::input(error)
    }
}

impl From<DeployError> for Failure {
    fn from(error: DeployError) -> Self {
        Self::input(error)
    }
}
