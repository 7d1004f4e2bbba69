//! `paid eval shooting`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::agreement::{self, AgreementReport};
use paid_eval::file::write_whole;
use paid_eval::html::write_report;
use paid_eval::picture::{HeatMap, Path as BallPath, plot_paths};
use paid_eval::shooting::{self, CellScore, Grid, ShootingOptions, ShootingReport, Variant};

use super::engine::{EngineName, positive};
use super::progress::Progress;
use super::subject::{Common, Subject};
use super::{Whole, to_json};
use crate::failure::Failure;

/// Arguments of `paid eval shooting`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Trials a ball place [default: 10; the paper's protocol has 50].
    #[arg(long, default_value_t = 10)]
    trials: usize,
    /// The ball rolls at 0.1 to 0.3 m/s in any direction.
    #[arg(long)]
    rolling: bool,
    /// Slowest and fastest rolling ball [m/s]; implies --rolling.
    #[arg(long, value_name = "M/S", num_args = 2)]
    speed: Option<Vec<f64>>,
    /// Ball places are given in the robot's first pose, as in the public evaluation (its displacement then has no effect),
    /// instead of in the world.
    #[arg(long)]
    robot_frame: bool,
    /// The paper's whole grid, [0.5, 3.0] x [-1.5, 1.5] m, instead of its effective workspace.
    #[arg(long)]
    whole_grid: bool,
    /// Radius of the disc of robot starts [m].
    #[arg(long, default_value_t = 0.5)]
    start_radius: f64,
    /// Width of the goal [m].
    #[arg(long, default_value_t = 2.0, value_parser = positive)]
    goal_width: f64,
    /// Distance of the goal ahead of the robot [m].
    #[arg(long, default_value_t = 5.0, value_parser = positive)]
    goal_distance: f64,
    /// Time limit of a trial [s].
    #[arg(long, default_value_t = 12.0)]
    limit: f64,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
    /// Write JSON, a CSV row a trial, heat maps, paths and report.html to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Scores in one engine, or in both with a comparison.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common, "stage2")?;
    subject.needs_ball()?;
    let rolling = match args.speed.as_deref() {
        Some([slow, fast]) => Some([*slow, *fast]),
        _ => args.rolling.then_some(shooting::ROLLING_SPEED),
    };
    let options = ShootingOptions {
        grid: if args.whole_grid { Grid::WHOLE } else { Grid::EFFECTIVE },
        trials: args.trials,
        variant: if args.robot_frame { Variant::Robot } else { Variant::World },
        start_radius_m: args.start_radius,
        rolling,
        goal_distance_m: args.goal_distance,
        goal_half_width_m: 0.5 * args.goal_width,
        limit_s: args.limit,
    };
    subject.arena.engine = subject.engine(args.common.engine);
    let progress = Progress::start(&subject.arena.monitor, args.json)?;
    let (text, json) = if args.common.engine == EngineName::Both {
        let report = agreement::evaluate(&subject.arena, &subject.scene, &*subject.maker, &options)
            .map_err(Failure::input)?;
        let timing = progress.finish();
        if let Some(out) = &args.out {
            write_agreement(out, &report)?;
        }
        let whole = Whole { kind: "agreement", policy: &subject.name, report: &report, timing };
        (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?)
    } else {
        let report = shooting::evaluate(&subject.arena, &*subject.maker, &options).map_err(Failure::input)?;
        let timing = progress.finish();
        let whole = Whole { kind: "shooting", policy: &subject.name, report: &report, timing };
        let json = to_json(&whole)?;
        if let Some(out) = &args.out {
            write_shooting(out, subject.arena.engine.name(), &report, &json)?;
        }
        (format!("{}\n{}", report.table(), timing.text()), json)
    };
    if let Some(out) = &args.out {
        write_report(out).map_err(Failure::input)?;
    }
    println!("{}", if args.json { json } else { text });
    let stopped = subject.arena.monitor.stopped();
    Ok(if stopped { ExitCode::from(130) } else { ExitCode::SUCCESS })
}

fn kind(report: &ShootingReport) -> &'static str {
    if report.options.rolling.is_some() { "rolling" } else { "static" }
}

fn write_agreement(out: &Path, report: &AgreementReport) -> Result<(), Failure> {
    let kind = kind(&report.builtin);
    write_shooting(out, "builtin", &report.builtin, &to_json(&report.builtin)?)?;
    write_shooting(out, "mujoco", &report.mujoco, &to_json(&report.mujoco)?)?;
    let csv = out.join(format!("both_{kind}_trials.csv"));
    write_whole(&csv, report.csv().as_bytes()).map_err(Failure::input)?;
    let text = out.join(format!("both_{kind}.txt"));
    write_whole(&text, report.table().as_bytes()).map_err(Failure::input)
}

fn write_shooting(out: &Path, engine: &str, report: &ShootingReport, json: &str) -> Result<(), Failure> {
    let kind = kind(report);
    let file = |what: &str| out.join(format!("{engine}_{kind}_{what}"));
    write_whole(&file("shooting.json"), json.as_bytes()).map_err(Failure::input)?;
    write_whole(&file("trials.csv"), report.csv().as_bytes()).map_err(Failure::input)?;
    let table = out.join(format!("{engine}_{kind}.txt"));
    write_whole(&table, report.table().as_bytes()).map_err(Failure::input)?;
    let grid = report.options.grid;
    let map = |title: &str, low: f64, factor: f64, value: fn(&CellScore) -> Option<f64>| HeatMap {
        title: format!("{title}, {kind} ball"),
        x: grid.places(grid.x),
        y: grid.places(grid.y),
        values: report.grid_values(value),
        low,
        high: 1.0,
        print: (factor, 0),
    };
    let maps = [
        ("success", map("success [%]", 0.0, 100.0, |c| Some(c.success.share))),
        ("accuracy", map("accuracy [%]", 0.0, 100.0, |c| c.accuracy)),
    ];
    for (name, map) in maps {
        map.figure().save(&file(name)).map_err(Failure::input)?;
    }
    let paths: Vec<BallPath> =
        report.trials.iter().map(|t| BallPath { points: &t.path, goal: t.goal }).collect();
    plot_paths(&paths, report.options.goal_half_width_m).save(&file("paths")).map_err(Failure::input)
}
