//! `paid eval gap`.

use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json};
use paid_eval::scene::Engines;
use paid_eval::shooting::Grid;
use paid_eval::subject::Subject;
use paid_lab::gap;
use paid_lab::results::write_gap;

use super::engine::count;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::Common;
use super::{Output, ended};
use crate::failure::Failure;

/// Arguments of `paid eval gap`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Trials per ball place, on the effective workspace (--whole-grid: on the paper's whole grid).
    #[arg(long, default_value_t = 4, value_parser = count)]
    trials: usize,
    #[command(flatten)]
    protocol: ProtocolArgs,
    #[command(flatten)]
    output: Output,
}

/// Runs every row, for each kind of ball; both engines run, whatever --engine says.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common.spec_of_referee("paper_stage2")?)?;
    subject.require_ball()?;
    Engines::Both.check()?;
    args.output.prepare()?;
    for options in args.protocol.options(args.trials, Grid::EFFECTIVE)? {
        let (monitor, progress) = Progress::start(args.output.json)?;
        subject.setup.monitor = monitor;
        let report = gap::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)?;
        let timing = progress.finish();
        let json = to_json(&Evaluation::new("gap", &subject.name, &report, timing))?;
        if args.output.nothing(&subject.setup.monitor, &timing) {
            break;
        }
        args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
        args.output.write(|out| {
            let kind = if options.rolling.is_some() { "rolling" } else { "static" };
            write_gap(out, kind, &report, &json)?;
            write_report(out)
        })?;
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    Ok(ended(&subject.setup.monitor))
}
