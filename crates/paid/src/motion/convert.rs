//! `paid motion convert`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_motion::{JointOrder, KickLeg, ReadOptions, read_motion, resample, write_motion};
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;

/// Arguments of `paid motion convert`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion file (.npz, .csv, GMR's .pkl).
    input: PathBuf,
    /// File to write; its name decides the format (.npz, .csv).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frames a second of a CSV file that does not state them.
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    /// Joint order of a CSV file that does not state it: model (depth-first) or policy (breadth-first).
    #[arg(long, value_name = "ORDER")]
    joint_order: Option<JointOrder>,
    /// Kicking leg [default: what the file states, else the leg with the faster foot].
    #[arg(long)]
    leg: Option<KickLeg>,
    /// Terms of use to state in the file [default: those that the input states].
    #[arg(long)]
    licence: Option<String>,
    /// Frame rate to write [Hz] [default: that of the input].
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
}

/// Reads, perhaps resamples, and writes.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let options = ReadOptions { fps: args.fps, kick_leg: args.leg, joint_order: args.joint_order };
    let mut clip = read_motion(&args.input, &model, &spec, &options).map_err(Failure::input)?;
    if let Some(rate) = args.rate {
        if !(1.0..=2000.0).contains(&rate) {
            return Err(Failure::input(format!("--rate: expected 1 to 2000 Hz, found {rate}")));
        }
        clip = resample(&clip, &model, rate);
    }
    clip.licence = args.licence.clone().or(clip.licence);
    write_motion(&args.out, &clip, &model, &spec).map_err(Failure::input)?;
    println!(
        "{}: {} frames at {} Hz, {} foot, licence: {}",
        args.out.display(),
        clip.frames,
        clip.fps,
        clip.kick_leg,
        clip.licence.as_deref().unwrap_or("not stated")
    );
    Ok(ExitCode::SUCCESS)
}
