//! `paid eval`: scores a policy and draws what it does.

pub mod demo;
mod engine;
pub mod episode;
mod film;
mod gap;
mod progress;
mod protocol;
mod shoot;
pub mod subject;
mod track;

use std::process::ExitCode;

use paid_eval::monitor::Monitor;
use progress::Timing;
use serde::Serialize;

use crate::failure::Failure;
use crate::stop::STOPPED;

/// Arguments of `paid eval`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// How closely the policy follows every motion.
    Tracking(track::Args),
    /// Shots at the goal from a grid of ball places.
    Shooting(Box<shoot::Args>),
    /// Which difference between the engines matters: the same shots in the built-in engine and in MuJoCo with one
    /// difference after the other taken away.
    Gap(Box<gap::Args>),
    /// Pictures of one episode.
    Film(film::Args),
    /// Write the scene of the evaluation as MJCF, for MuJoCo's own viewer.
    Scene(engine::SceneArgs),
}

/// Runs a subcommand.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Tracking(args) => track::run(&args),
        Command::Shooting(args) => shoot::run(&args),
        Command::Gap(args) => gap::run(&args),
        Command::Film(args) => film::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Scene(args) => engine::write_scene(&args).map(|()| ExitCode::SUCCESS),
    }
}

/// What an evaluation prints as JSON: the report, what it is about, and what it cost.
#[derive(Serialize)]
struct Whole<'a, R: Serialize> {
    kind: &'static str,
    policy: &'a str,
    #[serde(flatten)]
    report: &'a R,
    timing: Timing,
}

/// The exit code of an evaluation that ran to its end or was stopped.
fn ended(monitor: &Monitor) -> ExitCode {
    if monitor.stopped() { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS }
}

/// JSON for people and programs.
fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(Failure::input)
}
