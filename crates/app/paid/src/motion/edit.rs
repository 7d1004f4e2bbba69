//! `paid motion cut`, `paid motion mirror` and `paid motion join`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_motion::edit::{cut, join, label, mirror};
use paid_motion::{Clip, MotionLibrary, ReadOptions, kick_facts, resample, write_motion};
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;

/// Arguments of `paid motion cut`.
#[derive(Debug, clap::Args)]
pub struct CutArgs {
    /// Motion file of the robot (.npz, .csv, .pkl).
    input: PathBuf,
    /// File to write (.npz, .csv).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Start at this time of the file [s].
    #[arg(long, value_name = "S", default_value_t = 0.0)]
    from: f64,
    /// End at this time of the file [s] [default: its end].
    #[arg(long, value_name = "S")]
    to: Option<f64>,
    /// Move the stated kick frame by this many frames.
    #[arg(long, value_name = "FRAMES")]
    shift_kick: Option<i64>,
    /// Detect the kick again: the leg with the faster foot, and the frame of its peak.
    #[arg(long)]
    relabel: bool,
    /// Frame rate of a file that does not state it [Hz].
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
}

/// Arguments of `paid motion mirror`.
#[derive(Debug, clap::Args)]
pub struct MirrorArgs {
    /// Motion file of the robot (.npz, .csv, .pkl).
    input: PathBuf,
    /// File to write (.npz, .csv).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frame rate of a file that does not state it [Hz].
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
}

/// Arguments of `paid motion join`.
#[derive(Debug, clap::Args)]
pub struct JoinArgs {
    /// First clip: an approach, for example.
    ///
    /// For example the beginning of a kick of `paid motion generate`, cut out with `paid motion cut`.
    first: PathBuf,
    /// Second clip: a kick.
    second: PathBuf,
    /// File to write (.npz, .csv).
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Frame rate of files that do not state it [Hz].
    #[arg(long, value_name = "HZ")]
    fps: Option<f64>,
}

fn read(path: &Path, fps: Option<f64>, model: &RobotModel, spec: &RobotSpec) -> Result<Clip, Failure> {
    let options = ReadOptions { fps, ..ReadOptions::default() };
    MotionLibrary::read(path, model, spec, &options).map_err(Failure::input)
}

fn write(path: &Path, clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Result<ExitCode, Failure> {
    write_motion(path, clip, model, spec).map_err(Failure::input)?;
    let kick = clip.kick_frame.map_or_else(|| "not stated".to_owned(), |k| format!("in frame {k}"));
    println!(
        "{}: {} frames at {} Hz, {} foot, kick {kick}",
        path.display(),
        clip.frames,
        clip.fps,
        clip.kick_leg
    );
    Ok(ExitCode::SUCCESS)
}

/// Writes a part of a clip.
pub fn run_cut(args: &CutArgs) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clip = read(&args.input, args.fps, &model, &spec)?;
    let to = args.to.unwrap_or(f64::INFINITY);
    let Some(mut part) = cut(&clip, &model, args.from, to) else {
        let to = if to.is_finite() { format!("{to} s") } else { "the end".to_owned() };
        return Err(Failure::input(format!(
            "--from, --to: expected a part of at least 3 frames, found {} s to {to} of the {:.2} s of {}",
            args.from,
            clip.duration_s(),
            args.input.display()
        )));
    };
    if args.relabel {
        label(&mut part, &model, &spec);
    } else if args.shift_kick.is_some() && part.kick_frame.is_none() {
        if let Some(kick) = clip.kick_frame {
            return Err(Failure::input(format!(
                "--shift-kick: expected a part with the stated kick frame {kick}, found it cut off in {}; --relabel detects the kick again",
                args.input.display()
            )));
        }
        // Only the frame is missing: the leg stays as the file has it.
        part.kick_frame = kick_facts(&part, &model, &spec).map(|facts| facts.kick_frame);
    }
    if let (Some(by), Some(kick)) = (args.shift_kick, part.kick_frame) {
        let moved = i64::try_from(kick).ok().and_then(|k| k.checked_add(by));
        let moved = moved.and_then(|k| usize::try_from(k).ok()).filter(|k| *k < part.frames);
        let Some(moved) = moved else {
            return Err(Failure::input(format!(
                "--shift-kick: expected a frame of the clip (0 to {}), found {kick} moved by {by} in {}",
                part.frames - 1,
                args.input.display()
            )));
        };
        part.kick_frame = Some(moved);
    }
    write(&args.out, &part, &model, &spec)
}

/// Writes the mirror image of a clip.
pub fn run_mirror(args: &MirrorArgs) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let clip = read(&args.input, args.fps, &model, &spec)?;
    let image = mirror(&clip, &model, &spec).map_err(Failure::input)?;
    write(&args.out, &image, &model, &spec)
}

/// Writes one clip after another, at the second one's rate.
pub fn run_join(args: &JoinArgs) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let second = read(&args.second, args.fps, &model, &spec)?;
    let first = resample(&read(&args.first, args.fps, &model, &spec)?, &model, second.fps);
    let Some(both) = join(&first, &second, &model) else {
        return Err(Failure::input("expected two motions of one robot at one rate"));
    };
    write(&args.out, &both, &model, &spec)
}
