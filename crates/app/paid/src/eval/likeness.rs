//! `paid eval likeness`.

use std::path::PathBuf;
use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::likeness;
use paid_eval::results::{Evaluation, to_json, write_likeness};
use paid_eval::shooting::{Grid, ShootingOptions};

use super::engine::count;
use super::subject::Common;
use super::{Output, begin_with_ball, ended};
use crate::failure::Failure;

/// Arguments of `paid eval likeness`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Folder of motions to compare with [default: those that the policy follows].
    #[arg(long, value_name = "DIR")]
    clips: Option<PathBuf>,
    /// Shots at each of the 63 positions of the effective workspace.
    #[arg(long, default_value_t = 1, value_name = "N", value_parser = count)]
    trials: usize,
    #[command(flatten)]
    output: Output,
}

/// Compares a policy's kicks with the clips, writes and prints the report.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (subject, progress) = begin_with_ball(&args.common, &args.output)?;
    let setup = &subject.setup;
    let other = args.clips.as_ref().map(|folder| likeness::load_clips(folder, setup)).transpose()?;
    let clips = other.as_ref().unwrap_or(&setup.library);
    let options =
        ShootingOptions { grid: Grid::EFFECTIVE, trials: args.trials, ..ShootingOptions::default() };
    let report = likeness::evaluate(setup, &*subject.maker, clips, &subject.name, &options)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new("likeness", &subject.name, &report, timing))?;
    if args.output.nothing(&setup.monitor, &timing) {
        return Ok(ended(&setup.monitor));
    }
    args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    args.output.write(|out| {
        write_likeness(out, setup.engine.name(), &report, &json)?;
        write_report(out)
    })?;
    Ok(ended(&subject.setup.monitor))
}
