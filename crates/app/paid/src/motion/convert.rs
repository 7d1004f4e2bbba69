//! `paid motion convert`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_files::FileSet;
use paid_motion::{MotionLibrary, resample, write_motion};
use paid_retarget::{HumanOptions, amc_texts, bvh_text, is_human_file, read_human};
use paid_robot::{RobotModel, RobotSpec};

use super::robot_file::RobotFile;
use crate::failure::{Failure, first_given};

/// Arguments of `paid motion convert`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Motion of the robot (.npz, .csv, GMR's .pkl), or of a human (.bvh, .amc).
    input: PathBuf,
    /// File to write; its extension sets the format.
    ///
    /// .npz or .csv for the robot; .bvh or .amc (with its .asf next to it) for a human.
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frame rate of a file that does not state it [Hz]: CSV, AMC [default: 120].
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
    #[command(flatten)]
    file: RobotFile,
    /// Frame rate to write [Hz] [default: that of the input].
    #[arg(long, value_name = "HZ")]
    rate: Option<f64>,
    /// Skeleton of an AMC file [default: the .asf next to it].
    ///
    /// That is SUBJECT.asf, or the only one there.
    #[arg(long, value_name = "FILE")]
    skeleton: Option<PathBuf>,
    /// Length unit of the BVH or AMC file that is read [m].
    ///
    /// Default: 0.01 for BVH, what its ASF says for AMC. 0.01 is what is written.
    #[arg(long, value_name = "M")]
    unit: Option<f64>,
}

impl Args {
    /// The first option that is given and concerns a human's motion only.
    fn a_humans(&self) -> Option<&'static str> {
        first_given(&[("--skeleton", self.skeleton.is_some()), ("--unit", self.unit.is_some())])
    }
}

/// Reads, perhaps resamples, and writes.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if let Some(rate) = args.rate.filter(|rate| !(1.0..=2000.0).contains(rate)) {
        return Err(Failure::input(format!("--rate: expected 1 to 2000 Hz, found {rate}")));
    }
    for (extension, format) in [("bvh", HumanFormat::Bvh), ("amc", HumanFormat::Amc)] {
        if args.out.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension)) {
            return human(args, format);
        }
    }
    if !is_human_file(&args.input)
        && let Some(option) = args.a_humans()
    {
        return Err(Failure::input(format!(
            "{option}: expected a human's motion (.bvh, .amc), found {}",
            args.input.display()
        )));
    }
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut clip = MotionLibrary::read(&args.input, &model, &spec, &args.file.options(args.fps))
        .map_err(Failure::input)?;
    if let Some(rate) = args.rate {
        let seconds = clip.duration_s();
        clip = resample(&clip, &model, rate);
        if clip.frames < 2 {
            return Err(Failure::input(format!(
                "--rate: expected a rate that leaves 2 frames or more of the {seconds} s of {}, found {rate} Hz",
                args.input.display()
            )));
        }
    }
    let clip = args.file.licensed(clip);
    write_motion(&args.out, &clip, &model, &spec).map_err(Failure::input)?;
    println!(
        "{}: {} frames at {} Hz, {} foot, license: {}",
        args.out.display(),
        clip.frames,
        clip.fps,
        clip.kick_leg,
        clip.license.as_deref().unwrap_or("not stated")
    );
    Ok(ExitCode::SUCCESS)
}

/// Formats of human motion.
#[derive(Clone, Copy)]
enum HumanFormat {
    Bvh,
    Amc,
}

/// A human's motion in a format of human motion.
fn human(args: &Args, format: HumanFormat) -> Result<ExitCode, Failure> {
    if !is_human_file(&args.input) {
        return Err(Failure::input(format!(
            "{}: expected a human's motion (.bvh, .amc) to write {}, found another file",
            args.input.display(),
            args.out.display()
        )));
    }
    if let Some(option) = args.file.given() {
        return Err(Failure::input(format!(
            "{option}: expected a robot's motion to write, found {}",
            args.out.display()
        )));
    }
    let options = HumanOptions { unit_m: args.unit, fps: args.fps, skeleton: args.skeleton.clone() };
    let mut motion = read_human(&args.input, &options)?;
    for note in &motion.notes {
        eprintln!("note: {}: {note}", args.input.display());
    }
    if let Some(rate) = args.rate {
        motion = motion.resample(rate, 1.0);
    }
    let mut files = FileSet::default();
    match format {
        HumanFormat::Bvh => files.add(args.out.clone(), bvh_text(&motion).into_bytes()),
        HumanFormat::Amc => {
            let [skeleton, text] = amc_texts(&motion);
            files.add(args.out.with_extension("asf"), skeleton.into_bytes());
            files.add(args.out.clone(), text.into_bytes());
        }
    }
    files.write()?;
    let (file, bones) = (args.out.display(), motion.skeleton.bones.len());
    println!("{file}: {} frames at {} Hz, {bones} bones", motion.frames, motion.fps);
    Ok(ExitCode::SUCCESS)
}
