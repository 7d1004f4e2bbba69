//! `paid motion`: one module a subcommand.

mod check;
mod clean;
mod convert;
mod edit;
mod generate;
mod info;
mod likeness;
mod plot;
mod retarget;
mod robot_file;

use std::process::ExitCode;

use crate::failure::Failure;

pub use plot::Place;
pub use retarget::{How, retarget_file};

/// Arguments of `paid motion`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Print one line per motion file: leg, ball, foot speed, duration, license.
    Info(info::Args),
    /// Check that clips are fit for training: a verdict per clip, with reasons.
    ///
    /// Feet, joints, balance, label and license are checked.
    Check(check::Args),
    /// Compare the kicks of two folders: jerk, joint angles, foot path, swing.
    Likeness(likeness::Args),
    /// Plot a set of kicks, and advise which kick to record next.
    ///
    /// Trajectories, ball placement, foot speed and coverage.
    Plot(plot::Args),
    /// Generate kicks: the built-in library, or one kick for a given ball.
    Generate(generate::Args),
    /// Retarget human motion (BVH, ASF/AMC, point positions) to the robot.
    Retarget(retarget::Args),
    /// Clean a clip so that the robot can track it: feet, balance, limits, stands at both ends.
    Clean(clean::Args),
    /// Write a part of a clip, with its kick frame moved or detected again.
    Cut(edit::CutArgs),
    /// Write the mirror image of a clip: a left-footed kick from a right-footed one.
    Mirror(edit::MirrorArgs),
    /// Join two clips, such as an approach and a kick.
    Join(edit::JoinArgs),
    /// Write a motion file in another format (.npz, .csv, .bvh, .amc).
    Convert(convert::Args),
}

/// Runs a subcommand.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.command {
        Command::Info(args) => info::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Likeness(args) => likeness::run(&args),
        Command::Plot(args) => plot::run(&args),
        Command::Generate(args) => generate::run(&args),
        Command::Retarget(args) => retarget::run(&args),
        Command::Clean(args) => clean::run(&args),
        Command::Cut(args) => edit::run_cut(&args),
        Command::Mirror(args) => edit::run_mirror(&args),
        Command::Join(args) => edit::run_join(&args),
        Command::Convert(args) => convert::run(&args),
    }
}
