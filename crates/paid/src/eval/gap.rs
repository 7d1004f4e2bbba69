//! `paid eval gap`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::file::write_whole;
use paid_eval::gap;
use paid_eval::html::write_report;
use paid_eval::shooting::Grid;

use super::engine::EngineName;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::{Common, Subject};
use super::{Whole, ended, to_json};
use crate::failure::Failure;

/// Arguments of `paid eval gap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Trials a ball place; the grid is the effective workspace unless --whole-grid asks for more.
    #[arg(long, default_value_t = 4)]
    trials: usize,
    #[command(flatten)]
    protocol: ProtocolArgs,
    /// Print one line of JSON a kind of ball.
    #[arg(long)]
    json: bool,
    /// Write JSON, CSV, table and report.html to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Runs every row, for each kind of ball; both engines run, whatever --engine says.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common, "stage2")?;
    subject.needs_ball()?;
    Subject::needs_mujoco(EngineName::Both)?;
    for options in args.protocol.options(args.trials, Grid::EFFECTIVE)? {
        let (monitor, progress) = Progress::start(args.json)?;
        subject.setup.monitor = monitor;
        let report = gap::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)
            .map_err(Failure::input)?;
        let timing = progress.finish();
        let json = to_json(&Whole { kind: "gap", policy: &subject.name, report: &report, timing })?;
        if let Some(out) = &args.out {
            let kind = if options.rolling.is_some() { "rolling" } else { "static" };
            let file = |extension: &str| out.join(format!("gap_{kind}.{extension}"));
            write_whole(&file("json"), json.as_bytes()).map_err(Failure::input)?;
            write_whole(&file("csv"), report.csv().as_bytes()).map_err(Failure::input)?;
            write_whole(&file("txt"), report.table().as_bytes()).map_err(Failure::input)?;
            write_report(out).map_err(Failure::input)?;
        }
        if args.json {
            println!("{json}");
        } else {
            println!("{}\n{}\n", report.table(), timing.text());
        }
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    Ok(ended(&subject.setup.monitor))
}
