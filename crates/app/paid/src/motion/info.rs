//! `paid motion info`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_motion::{KickFacts, MotionLibrary, kick_facts};
use paid_robot::{RobotModel, RobotSpec};
use serde::Serialize;

use crate::failure::Failure;

/// Arguments of `paid motion info`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Folder of motion files (.npz, .csv, .pkl) [default: the built-in kicks].
    dir: Option<PathBuf>,
    /// Control rate that clips are resampled to [Hz].
    #[arg(long, default_value_t = 50.0)]
    rate: f64,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Serialize)]
struct Line<'a> {
    name: &'a str,
    path: String,
    kick_leg: paid_motion::KickLeg,
    frames: usize,
    fps: f64,
    duration_s: f64,
    license: Option<&'a str>,
    #[serde(flatten)]
    facts: KickFacts,
}

/// Prints one line per clip.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let folder = args.dir.clone().unwrap_or_default();
    let library = MotionLibrary::open(&folder, &model, &spec, args.rate).map_err(Failure::input)?;
    let mut lines = Vec::new();
    for clip in &library.clips {
        let facts = kick_facts(clip, &model, &spec)
            .ok_or_else(|| Failure::input("the robot's TOML names a body that its MJCF lacks"))?;
        lines.push(Line {
            name: &clip.name,
            path: clip.path.display().to_string(),
            kick_leg: clip.kick_leg,
            frames: clip.frames,
            fps: clip.fps,
            duration_s: clip.duration_s(),
            license: clip.license.as_deref(),
            facts,
        });
    }
    if args.json {
        println!("{}", serde_json::to_string_pretty(&lines).map_err(Failure::input)?);
        return Ok(ExitCode::SUCCESS);
    }
    let width = lines.iter().map(|l| l.name.len()).max().unwrap_or(4).max(4);
    println!(
        "{:<width$}  leg    frames  time s  forward m  left m  peak foot m/s  at phase  lift m  lowest mm",
        "clip"
    );
    for line in &lines {
        let KickFacts {
            anchor_displacement: [x, y],
            peak_foot_speed,
            kick_phase,
            lift_m,
            lowest_point_m,
            ..
        } = line.facts;
        println!(
            "{:<width$}  {:<5}  {:>6}  {:>6.2}  {x:>9.2}  {y:>6.2}  {peak_foot_speed:>13.2}  {kick_phase:>8.2}  \
             {lift_m:>6.3}  {:>9.1}",
            line.name,
            line.kick_leg.to_string(),
            line.frames,
            line.duration_s,
            1e3 * lowest_point_m
        );
    }
    Ok(ExitCode::SUCCESS)
}
