//! `paid eval`: scores a policy and draws what it does.

mod engine;
mod film;
mod progress;
mod shoot;
mod subject;
mod track;

use std::process::ExitCode;

use progress::Timing;
use serde::Serialize;

use crate::failure::Failure;

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

/// JSON for people and programs.
fn to_json(value: &impl Serialize) -> Result<String, Failure> {
    serde_json::to_string(value).map_err(Failure::input)
}
