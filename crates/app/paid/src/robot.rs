//! `paid robot`: a policy on a G1, and a virtual G1 that nobody can break.

mod mirror;
mod network;
mod offline;
mod screen;
mod serve;
mod verify;
mod watch;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use clap::Subcommand;
use paid_runtime::{DeployError, Event, Latency, Limits, Player, PlayerSpec, Usage};
use paid_twin::TwinError;

use crate::failure::Failure;

/// Arguments of `paid robot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// A virtual G1: on the network in real time, or in lockstep with the runtime, kick after kick.
    Sim(offline::SimArgs),
    /// Run a policy on the robot: damping, stand up, wait for a ball, kick, settle.
    Run(network::RunArgs),
    /// Read the robot's states for a while and say what they are like. Commands nothing.
    Check(network::CheckArgs),
    /// Run a log through the runtime again and compare everything bit for bit.
    Replay(verify::ReplayArgs),
    /// Inject every fault into the virtual G1 and measure how soon it is damped.
    Drill(verify::DrillArgs),
}

/// Policy and motions.
#[derive(Debug, clap::Args)]
struct PlayerArgs {
    /// Run folder or checkpoint.
    #[arg(long, value_name = "RUN|FILE")]
    policy: PathBuf,
    /// Folder of the motions [default: those that the policy was trained on].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Change a value of the policy's task, such as ball.after_strike.show="where_it_lay" (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// TOML file of limits.
    #[arg(long, value_name = "FILE")]
    limits: Option<PathBuf>,
}

impl PlayerArgs {
    fn spec(&self) -> PlayerSpec {
        PlayerSpec { policy: self.policy.clone(), motions: self.motions.clone(), sets: self.sets.clone() }
    }

    fn load(&self) -> Result<(Arc<Player>, Limits), Failure> {
        let limits = read_limits(self.limits.as_deref())?;
        Ok((Arc::new(Player::load(&self.spec()).map_err(Failure::input)?), limits))
    }
}

/// Limits of a file, or the usual ones.
fn read_limits(file: Option<&Path>) -> Result<Limits, Failure> {
    file.map_or_else(|| Ok(Limits::default()), |file| Limits::read(file).map_err(Failure::input))
}

/// Longest time that may be asked for: more than a week `[s]`.
const LONGEST_S: f64 = 1e6;

/// The time of `--seconds`.
fn duration(seconds: f64) -> Result<Duration, Failure> {
    if (0.0..=LONGEST_S).contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Failure::input(format!("--seconds: expected 0 to {LONGEST_S}, found {seconds:?}")))
}

/// Refuses a number of things that is none.
fn at_least_one(option: &str, found: usize) -> Result<usize, Failure> {
    if found > 0 { Ok(found) } else { Err(Failure::input(format!("{option}: expected at least 1, found 0"))) }
}

/// The network, named in full: nothing is chosen by itself.
#[derive(Debug, clap::Args)]
struct NetworkArgs {
    /// DDS domain: 0 is the robot's, 1 the simulators'.
    #[arg(long, value_name = "N")]
    domain: u16,
    /// Address of this machine's interface to the robot, such as 192.168.123.99; 127.0.0.1 for a virtual robot on this machine.
    #[arg(long, value_name = "ADDRESS")]
    interface: std::net::IpAddr,
    /// The robot is a simulator without motion switcher: nobody is asked whether the vendor's controller is released.
    #[arg(long)]
    no_switcher: bool,
}

/// A transition on a line of its own.
fn print_event(event: &Event) {
    println!("{:>10.3} s  {} -> {}: {}", event.at_us as f64 * 1e-6, event.from, event.to, event.reason);
}

/// The distribution from capture to joint targets, on a line of its own.
fn print_latency(latency: &Latency) {
    let Some(figures) = latency.figures() else { return };
    let [least, lowest, low, half, most, nearly_all, all] = figures.within_ms;
    println!(
        "from capture to joint targets: {least:.0} ms at least, then {lowest:.0} / {low:.0} / {half:.0} / {most:.0} / {nearly_all:.0} / {all:.0} ms (1 / 5 / 50 / 95 / 99 / 100% of {} pictures)",
        figures.pictures
    );
}

/// What the program has taken of the machine, on a line of its own.
fn print_usage(usage: &Usage) {
    println!(
        "{:.1} s of processor time in {:.1} s: {:.2} of a core; {:.0} MiB at most",
        usage.cores * usage.clock_s,
        usage.clock_s,
        usage.cores,
        usage.peak_rss_mib
    );
}

/// Runs it.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Sim(args) => offline::sim(&args),
        Command::Run(args) => network::run(&args),
        Command::Check(args) => network::check(&args),
        Command::Replay(args) => verify::replay(&args),
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
