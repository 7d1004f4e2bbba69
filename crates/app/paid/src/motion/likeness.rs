//! `paid motion likeness`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::likeness;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_robot::{RobotModel, RobotSpec};

use crate::failure::Failure;

/// Arguments of `paid motion likeness`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of motion files (.npz, .csv, .pkl) [default: the built-in kicks].
    dir: Option<PathBuf>,
    /// Folder of motions to compare with.
    #[arg(long, value_name = "DIR")]
    clips: PathBuf,
    /// Control rate that clips are resampled to [Hz].
    #[arg(long, default_value_t = 50.0)]
    rate: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Prints how the kicks of one folder compare with those of another.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let robot = (&RobotModel::g1(), &RobotSpec::g1());
    let load = |folder: &Path| -> Result<ReferenceLibrary, Failure> {
        let motions = MotionLibrary::open(folder, robot.0, robot.1, args.rate).map_err(Failure::input)?;
        ReferenceLibrary::from_motions(&motions, robot.0, robot.1).map_err(Failure::input)
    };
    let name = args.dir.as_ref().map_or("the built-in kicks".to_owned(), |dir| dir.display().to_string());
    let library = load(args.dir.as_deref().unwrap_or(Path::new("")))?;
    let rows = likeness::of_library(&library, &load(&args.clips)?, robot, &name).map_err(Failure::input)?;
    if args.json {
        println!("{}", serde_json::to_string_pretty(&rows).map_err(Failure::input)?);
    } else {
        print!("{}", likeness::table(&rows));
    }
    Ok(ExitCode::SUCCESS)
}
