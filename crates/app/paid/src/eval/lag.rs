//! `paid eval lag`.

use std::process::ExitCode;

use paid_eval::lag;
use paid_eval::results::{Evaluation, to_json, write_lag};
use paid_eval::shooting::{Grid, ShootingOptions};

use super::engine::count;
use super::subject::Common;
use super::{Output, begin_with_ball, ended};
use crate::failure::Failure;

/// Arguments of `paid eval lag`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Shots at each of the 63 positions of the effective workspace.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = count)]
    trials: usize,
    #[command(flatten)]
    output: Output,
}

/// Measures the joints of a policy's shots, writes and prints the report.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (subject, progress) = begin_with_ball(&args.common, &args.output)?;
    let setup = &subject.setup;
    let options =
        ShootingOptions { grid: Grid::EFFECTIVE, trials: args.trials, ..ShootingOptions::default() };
    let report = lag::evaluate(setup, &*subject.maker, &options)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new("lag", &subject.name, &report, timing))?;
    if args.output.nothing(&setup.monitor, &timing) {
        return Ok(ended(&setup.monitor));
    }
    args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    args.output.write(|out| write_lag(out, setup.engine.name(), &report, &json))?;
    Ok(ended(&subject.setup.monitor))
}
