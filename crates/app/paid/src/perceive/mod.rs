//! `paid perceive`: what the robot's eyes are made of.

mod calibrate;
mod detect;
mod fit;
mod odometry;
mod replay;
mod train;

use std::path::Path;
use std::process::ExitCode;

use paid_vision::detect::Detector;

use crate::failure::Failure;

/// Arguments of `paid perceive`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Evaluate a ball detector on rendered images that training never saw.
    Detect(detect::Args),
    /// Train the ball detector on rendered images (needs --features train-detector).
    Train(train::Args),
    /// Calibrate the camera's pose on the torso from a few views of a ball that lies still.
    Calibrate(calibrate::Args),
    /// Measure the LiDAR-inertial odometry on a simulated Mid-360 that walks and kicks.
    Odometry(odometry::Args),
    /// Fit the noise model's constants to the detections of an evaluation.
    Fit(fit::Args),
    /// Run perception again on a recording, and compare the estimates.
    Replay(replay::Args),
}

/// Runs a subcommand.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    match &args.command {
        Command::Detect(args) => detect::run(args),
        Command::Train(args) => return train::run(args),
        Command::Calibrate(args) => calibrate::run(args),
        Command::Odometry(args) => odometry::run(args),
        Command::Fit(args) => fit::run(args),
        Command::Replay(args) => replay::run(args),
    }
    .map(|()| ExitCode::SUCCESS)
}

/// A detector of the user. What the file is taken for is printed to standard error: the results are elsewhere.
pub fn load(path: &Path, class: Option<usize>) -> Result<Detector, Failure> {
    let detector = Detector::load(path, class).map_err(Failure::input)?;
    eprintln!("{}", detector.taken_for());
    Ok(detector)
}
