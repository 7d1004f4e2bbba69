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
    /// Print what the kick in every motion file below a folder looks like, one line per clip.
    Info(info::Args),
    /// Check that clips are fit to train on (feet, joints, balance, label, license): a verdict with its reasons per clip.
    Check(check::Args),
    /// Compare the kicks of a folder with those of another: jerk, joint angles, path of the foot, swing.
    Likeness(likeness::Args),
    /// Draw a set of kicks (ways, placement, foot speed, coverage) and say which kick to record next.
    Plot(plot::Args),
    /// Make kicks from scratch: the built-in library, or one kick for a ball of your choice.
    Generate(generate::Args),
    /// Retarget a human's motion (BVH, ASF/AMC, positions of points) to the robot.
    Retarget(retarget::Args),
    /// Make a clip fit for the robot: feet hold still on the floor, balance, limits, a stand at both ends.
    Clean(clean::Args),
    /// Write a part of a clip, its kick frame moved or found anew.
    Cut(edit::CutArgs),
    /// Write a clip's mirror image: a left-footed kick of a right-footed one.
    Mirror(edit::MirrorArgs),
    /// Write one clip after another, such as an approach and a kick.
    Join(edit::JoinArgs),
    /// Write a motion file in another format (.npz, .csv).
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
