//! `paid eval clips`.

use std::process::ExitCode;

use paid_eval::clips::{self, ClipsOptions};
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_clips};

use super::engine::{count, positive};
use super::subject::Common;
use super::{Output, begin_with_ball, ended};
use crate::failure::Failure;

/// Arguments of `paid eval clips`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Shots per clip.
    #[arg(long, default_value_t = 40, value_parser = count)]
    trials: usize,
    /// Largest distance of a ball from the clip's own ball [m].
    #[arg(long, value_name = "M", default_value_t = 0.25, value_parser = positive)]
    radius: f64,
    /// Time limit of a shot [s].
    #[arg(long, value_name = "S", default_value_t = 12.0, value_parser = positive)]
    limit: f64,
    #[command(flatten)]
    output: Output,
}

/// Shoots with every clip, writes and prints the report.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let (subject, progress) = begin_with_ball(&args.common, &args.output)?;
    let options = ClipsOptions { trials: args.trials, radius_m: args.radius, limit_s: args.limit };
    let report = clips::evaluate(&subject.setup, &*subject.maker, &options)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new("clips", &subject.name, &report, timing))?;
    if args.output.nothing(&subject.setup.monitor, &timing) {
        return Ok(ended(&subject.setup.monitor));
    }
    args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    args.output.write(|out| {
        write_clips(out, subject.setup.engine.name(), &report, &json)?;
        write_report(out)
    })?;
    Ok(ended(&subject.setup.monitor))
}
