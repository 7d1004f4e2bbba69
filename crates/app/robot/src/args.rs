//! Arguments and lines that the commands share.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use paid_runtime::wire::check_domain;
use paid_runtime::{Event, Latency, Limits, Player, PlayerSpec, Usage};

use paid_terminal::Failure;

/// Policy and motions.
#[derive(Debug, clap::Args)]
pub struct PlayerArgs {
    /// Policy: run folder, checkpoint or policy file.
    #[arg(long, value_name = "POLICY")]
    pub policy: PathBuf,
    /// Folder of motion files [default: those the policy was trained on].
    #[arg(long, value_name = "DIR")]
    pub motions: Option<PathBuf>,
    /// Change how the policy is played (repeatable).
    ///
    /// For example ball.after_strike.show="where_it_lay".
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub sets: Vec<String>,
    /// TOML file of safety limits.
    #[arg(long, value_name = "FILE")]
    pub limits: Option<PathBuf>,
}

impl PlayerArgs {
    /// Where the player comes from.
    pub fn spec(&self) -> PlayerSpec {
        PlayerSpec { policy: self.policy.clone(), motions: self.motions.clone(), sets: self.sets.clone() }
    }

    /// Player and limits.
    ///
    /// # Errors
    /// If a file is missing or does not fit.
    pub fn load(&self) -> Result<(Arc<Player>, Limits), Failure> {
        let limits = read_limits(self.limits.as_deref())?;
        Ok((Arc::new(Player::load(&self.spec()).map_err(Failure::input)?), limits))
    }
}

/// Limits of a file, or the usual ones.
///
/// # Errors
/// If the file is missing or does not fit.
pub fn read_limits(file: Option<&Path>) -> Result<Limits, Failure> {
    file.map_or_else(|| Ok(Limits::default()), |file| Limits::read(file).map_err(Failure::input))
}

/// Longest time that may be asked for: more than a week `[s]`.
const LONGEST_S: f64 = 1e6;

/// The time of `--seconds`.
///
/// # Errors
/// If it is negative, or more than a week.
pub fn duration(seconds: f64) -> Result<Duration, Failure> {
    if (0.0..=LONGEST_S).contains(&seconds) {
        return Ok(Duration::from_secs_f64(seconds));
    }
    Err(Failure::input(format!("--seconds: expected 0 to {LONGEST_S}, found {seconds:?}")))
}

/// Refuses a number of things that is none.
///
/// # Errors
/// If it is none.
pub fn at_least_one(option: &str, found: usize) -> Result<usize, Failure> {
    if found > 0 { Ok(found) } else { Err(Failure::input(format!("{option}: expected at least 1, found 0"))) }
}

/// A DDS domain whose ports exist.
///
/// # Errors
/// What was expected.
pub fn domain(text: &str) -> Result<u16, String> {
    check_domain(text.parse().ok())
}

/// The network, named in full: nothing is chosen by itself.
#[derive(Debug, clap::Args)]
pub struct NetworkArgs {
    /// DDS domain: 0 for the robot, 1 for simulators.
    #[arg(long, help_heading = "Network", value_name = "N", value_parser = domain)]
    pub domain: u16,
    /// Address of this machine's interface to the robot, such as 192.168.123.99.
    ///
    /// 127.0.0.1 for a virtual robot on this machine.
    #[arg(long, help_heading = "Network", value_name = "ADDRESS")]
    pub interface: std::net::IpAddr,
    /// For a simulator: do not ask the motion switcher whether the vendor's controller is off.
    #[arg(long, help_heading = "Network")]
    pub no_switcher: bool,
}

/// A transition on a line of its own.
pub fn print_event(event: &Event) {
    println!("{:>10.3} s  {} -> {}: {}", event.at_us as f64 * 1e-6, event.from, event.to, event.reason);
}

/// The distribution from capture to joint targets, on a line of its own.
pub fn print_latency(latency: &Latency) {
    let Some(figures) = latency.figures() else { return };
    let [least, lowest, low, half, most, nearly_all, all] = figures.within_ms;
    println!(
        "from capture to joint targets: {least:.0} ms at least, then {lowest:.0} / {low:.0} / {half:.0} / {most:.0} / {nearly_all:.0} / {all:.0} ms (1 / 5 / 50 / 95 / 99 / 100% of {} images)",
        figures.pictures
    );
}

/// What the program has taken of the machine, on a line of its own.
pub fn print_usage(usage: &Usage) {
    println!(
        "{:.1} s of processor time in {:.1} s: {:.2} of a core; {:.0} MiB at most",
        usage.cores * usage.clock_s,
        usage.clock_s,
        usage.cores,
        usage.peak_rss_mib
    );
}
