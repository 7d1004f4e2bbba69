//! `paid motion plot`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::shooting::Grid;
use paid_lab::dataset::Dataset;
use paid_motion::check::{CheckLimits, Verdict, check_clip};
use paid_motion::{Clip, MotionLibrary};
use paid_play::OwnPlace;
use paid_robot::{RobotModel, RobotSpec};

use super::robot_file::expect_folder;
use crate::failure::Failure;

/// Arguments of `paid motion plot`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of motion files (.npz, .csv, .pkl) [default: the built-in kicks].
    dir: Option<PathBuf>,
    /// Folder for the images, each as .png and .svg.
    ///
    /// trajectories, placement, foot_speed and coverage.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Balls that the kicks should cover.
    #[arg(long, value_enum, default_value_t = Workspace::Effective)]
    workspace: Workspace,
    /// Where a kick's own ball lies.
    #[arg(long, value_enum, default_value_t = Place::TorsoEnd)]
    place: Place,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Workspace {
    /// 0.5 to 2 m ahead, 1 m to either side.
    Effective,
    /// 0.5 to 3 m ahead, 1.5 m to either side.
    Whole,
}

/// Where a kick's own ball lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Place {
    /// Where the torso ends, as in the paper.
    TorsoEnd,
    /// In front of the striking foot (task.ball.own_place=strike).
    Strike,
}

impl From<Place> for OwnPlace {
    fn from(place: Place) -> Self {
        match place {
            Place::TorsoEnd => Self::TorsoEnd,
            Place::Strike => Self::Strike,
        }
    }
}

/// Names the clips that fail the check, each with its worst reason: their places and speeds may mean nothing.
fn failing(clips: &[Clip], model: &RobotModel, spec: &RobotSpec) -> Result<Option<String>, Failure> {
    let mut found = Vec::new();
    for clip in clips {
        let report = check_clip(clip, model, spec, &CheckLimits::default()).map_err(Failure::input)?;
        let worst = report.findings.first().filter(|finding| finding.verdict == Verdict::Fail);
        found.extend(worst.map(|finding| format!("{} ({})", clip.path.display(), finding.reason)));
    }
    let (some, all) = (found.len(), clips.len());
    Ok((some > 0).then(|| {
        format!(
            "{some} of {all} clips fail `paid motion check` and are drawn as they are: {}",
            found.join(", ")
        )
    }))
}

/// Draws the plots and prints what the kicks cover and which one to record next.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    expect_folder(&args.out)?;
    if let Some(folder) = &args.dir {
        // At the files' own rates: resampling would smooth over what is to be found.
        let library = MotionLibrary::load_unchanged(folder, &model, &spec).map_err(Failure::input)?;
        if let Some(note) = failing(&library.clips, &model, &spec)? {
            eprintln!("note: {note}");
        }
    }
    let folder = args.dir.clone().unwrap_or_default();
    let library =
        MotionLibrary::open(&folder, &model, &spec, paid_motion::generate::FPS).map_err(Failure::input)?;
    let grid = match args.workspace {
        Workspace::Effective => Grid::EFFECTIVE,
        Workspace::Whole => Grid::WHOLE,
    };
    let set = Dataset::new(&library.clips, &model, &spec, grid, args.place.into())?;
    set.write(&args.out)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&set).map_err(Failure::input)?);
        return Ok(ExitCode::SUCCESS);
    }
    let coverage = &set.coverage;
    println!(
        "{}: trajectories, placement, foot_speed and coverage (.png, .svg) of {} kicks",
        args.out.display(),
        set.kicks.len()
    );
    println!("{}\n{}", coverage.share(), coverage.advice());
    Ok(ExitCode::SUCCESS)
}
