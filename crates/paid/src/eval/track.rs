//! `paid eval tracking`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::file::write_whole;
use paid_eval::html::write_report;
use paid_eval::tracking::{self, TrackingOptions, TrackingReport};
use paid_eval::tracking_agreement;

use super::engine::EngineName;
use super::progress::Progress;
use super::subject::{Common, Subject};
use super::{Whole, ended, to_json};
use crate::failure::Failure;

/// Arguments of `paid eval tracking`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Starts with reset noise a clip, besides the exact one.
    #[arg(long, default_value_t = 20)]
    starts: usize,
    /// Runs end at the motion's end or a fall only, not at the limits of training: for policies that drift.
    #[arg(long)]
    no_limits: bool,
    /// Print one line of JSON.
    #[arg(long)]
    json: bool,
    /// Write JSON, table, a plot of the clips' errors and report.html to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Scores in one engine, or in both with a comparison.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common, "stage1")?;
    let options =
        TrackingOptions { starts: args.starts, sets: subject.sets.clone(), limits: !args.no_limits };
    subject.setup.engine = subject.engine(args.common.setting.engine);
    let (monitor, progress) = Progress::start(args.json)?;
    subject.setup.monitor = monitor;
    let (text, json) = if args.common.setting.engine == EngineName::Both {
        let report = tracking_agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)
            .map_err(Failure::input)?;
        let timing = progress.finish();
        if let Some(out) = &args.out {
            write_tracking(out, "builtin", &report.builtin, &to_json(&report.builtin)?)?;
            write_tracking(out, "mujoco", &report.mujoco, &to_json(&report.mujoco)?)?;
            let csv = out.join("both_tracking_runs.csv");
            write_whole(&csv, report.csv().as_bytes()).map_err(Failure::input)?;
            let text = out.join("both_tracking.txt");
            write_whole(&text, report.table().as_bytes()).map_err(Failure::input)?;
        }
        let whole = Whole { kind: "tracking_agreement", policy: &subject.name, report: &report, timing };
        let tables = [report.builtin.table(), report.mujoco.table(), report.table()];
        (format!("{}\n{}", tables.join("\n"), timing.text()), to_json(&whole)?)
    } else {
        let report = tracking::evaluate(&subject.setup, &*subject.maker, &options).map_err(Failure::input)?;
        let timing = progress.finish();
        let whole = Whole { kind: "tracking", policy: &subject.name, report: &report, timing };
        let json = to_json(&whole)?;
        if let Some(out) = &args.out {
            write_tracking(out, subject.setup.engine.name(), &report, &json)?;
        }
        (format!("{}\n{}", report.table(), timing.text()), json)
    };
    if let Some(out) = &args.out {
        write_report(out).map_err(Failure::input)?;
    }
    println!("{}", if args.json { json } else { text });
    Ok(ended(&subject.setup.monitor))
}

fn write_tracking(out: &Path, engine: &str, report: &TrackingReport, json: &str) -> Result<(), Failure> {
    let file = |what: &str| out.join(format!("{engine}_tracking{what}"));
    write_whole(&file(".json"), json.as_bytes()).map_err(Failure::input)?;
    write_whole(&file(".txt"), report.table().as_bytes()).map_err(Failure::input)?;
    report.error_bars().figure().save(&file("_errors")).map_err(Failure::input)
}
