//! `paid sysid`: a ball's behavior from filmed drops and rolls, or such films from a known ball.

mod fit;
mod identification;
mod simulate;

use std::process::ExitCode;

use paid_physics::{BallParams, SceneConfig};
use paid_sysid::options::{PARAMETERS, Parameters};

use crate::failure::Failure;

/// Arguments of `paid sysid`.
#[derive(Debug, clap::Args)]
#[command(args_conflicts_with_subcommands = true)]
pub struct Args {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    fit: fit::FitArgs,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Simulate measurements of a known ball, to test the identification.
    Simulate(simulate::Args),
}

/// Runs the identification or a subcommand.
pub fn run(args: Args, given: &[String]) -> Result<ExitCode, Failure> {
    match args.command {
        Some(Command::Simulate(args)) => simulate::run(&args, given),
        None => fit::run(&args.fit),
    }
    .map(|()| ExitCode::SUCCESS)
}

/// Which task's ground and ball are meant.
#[derive(Debug, clap::Args)]
struct World {
    /// Run preset of ground and ball: built in, or a file.
    ///
    /// The ground of its task is held fixed. The ball of its task gives mass, radius, inertia and what the films do not show.
    #[arg(long, help_heading = "Task", value_name = "NAME|FILE", default_value = "paper_stage2")]
    task: String,
    /// Change a task value, such as scene.ground.restitution=1 (repeatable).
    #[arg(long = "set", help_heading = "Task", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Instruction set: auto, avx512, avx2 or portable. Each rounds differently.
    #[arg(long, hide_short_help = true, help_heading = "Task", default_value = "auto")]
    isa: String,
}

impl World {
    fn load(&self) -> Result<(SceneConfig, BallParams), Failure> {
        let preset = paid_train::task_preset(&self.task, &self.sets).map_err(Failure::input)?;
        Ok((preset.scene, preset.ball_params))
    }
}

/// Five numbers: static and dynamic friction, restitution, linear and angular damping.
fn five(text: &str) -> Result<Parameters, String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match <[f64; PARAMETERS]>::try_from(numbers) {
        Ok(five) if text.matches(',').count() + 1 == PARAMETERS && five.iter().all(|x| x.is_finite()) => {
            Ok(five)
        }
        _ => Err(format!("expected five numbers such as 0.77,0.07,0.75,0.01,4.28, found '{text}'")),
    }
}
