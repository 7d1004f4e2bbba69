//! `paid motion`: one module a subcommand.

mod check;
mod convert;
mod generate;
mod info;
mod retarget;

use std::process::ExitCode;

use crate::failure::Failure;

pub use retarget::{How, retarget_file};

/// Arguments of `paid motion`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Print what the kick in every motion file below a folder looks like, one line per clip.
    Info(info::Args),
    /// Check that clips are fit to train on (feet, joints, balance, label, license): a verdict with its reasons per clip.
    Check(check::Args),
    /// Make kicks from scratch: the built-in library, or one kick for a ball of your choice.
    Generate(generate::Args),
    /// Retarget a human's motion (BVH, ASF/AMC) to the robot.
    Retarget(retarget::Args),
    /// Write a motion file in another format (.npz, .csv).
    Convert(convert::Args),
}

/// Runs a subcommand.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Info(args) => info::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Retarget(args) => retarget::run(&args),
        Command::Convert(args) => convert::run(&args),
    }
}
