//! `paid perceive`: what the robot's eyes are made of.

mod calibrate;
mod detect;
mod odometry;
mod train;

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid perceive`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Judge a ball detector on rendered pictures that training never saw.
    Detect(detect::Args),
    /// Train the project's own ball detector on rendered pictures (needs the cargo feature train-detector).
    Train(train::Args),
    /// Find out where the camera sits on the torso from a few views of a ball that lies still.
    Calibrate(calibrate::Args),
    /// Measure the LiDAR-inertial odometry on a simulated Mid-360 that walks and kicks.
    Odometry(odometry::Args),
}

/// Runs a subcommand.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    match &args.command {
        Command::Detect(args) => detect::run(args),
        Command::Train(args) => train::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Odometry(args) => odometry::run(args),
    }
    .map(|()| ExitCode::SUCCESS)
}
