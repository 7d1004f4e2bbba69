//! `paid eval tracking`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::file::write_whole;
use paid_eval::html::write_report;
use paid_eval::tracking::{self, TrackingOptions};

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
    /// Print one line of JSON an engine.
    #[arg(long)]
    json: bool,
    /// Write JSON, table, a plot of the clips' errors and report.html to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Scores in one engine or in both, one after the other.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common, "stage1")?;
    let options =
        TrackingOptions { starts: args.starts, sets: subject.sets.clone(), limits: !args.no_limits };
    let engines = match args.common.engine {
        EngineName::Both => vec![EngineName::Builtin, EngineName::Mujoco],
        one => vec![one],
    };
    for engine in engines {
        subject.arena.engine = subject.engine(engine);
        let (monitor, progress) = Progress::start(args.json)?;
        subject.arena.monitor = monitor;
        let report = tracking::evaluate(&subject.arena, &*subject.maker, &options).map_err(Failure::input)?;
        let timing = progress.finish();
        let whole = Whole { kind: "tracking", policy: &subject.name, report: &report, timing };
        let json = to_json(&whole)?;
        if let Some(out) = &args.out {
            let file = format!("{}_tracking.json", subject.arena.engine.name());
            write_whole(&out.join(file), json.as_bytes()).map_err(Failure::input)?;
            let name = |what: &str| out.join(format!("{}_tracking{what}", subject.arena.engine.name()));
            write_whole(&name(".txt"), report.table().as_bytes()).map_err(Failure::input)?;
            report.error_bars().figure().save(&name("_errors")).map_err(Failure::input)?;
            write_report(out).map_err(Failure::input)?;
        }
        if args.json {
            println!("{json}");
        } else {
            println!("{}\n{}\n", report.table(), timing.text());
        }
        if subject.arena.monitor.stopped() {
            break;
        }
    }
    Ok(ended(&subject.arena.monitor))
}
