//! `paid eval tracking`.

use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_tracking};
use paid_eval::scene::Engines;
use paid_eval::subject::Subject;
use paid_eval::tracking::{self, TrackingOptions};
use paid_lab::results::write_tracking_agreement;
use paid_lab::tracking_agreement;

use super::engine::count;
use super::progress::Progress;
use super::subject::Common;
use super::{Output, ended, shared};
use crate::failure::Failure;

/// Perturbed starts per clip.
pub const STARTS: usize = 20;

/// Arguments of `paid eval tracking`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Perturbed starts per clip, in addition to the exact one.
    #[arg(long, default_value_t = STARTS, value_parser = count)]
    starts: usize,
    /// End a run only at the motion's end or at a fall, for policies that drift.
    ///
    /// Otherwise a run also ends at the limits used in training.
    #[arg(long)]
    no_limits: bool,
    #[command(flatten)]
    output: Output,
}

/// Scores in one engine, or in both with a comparison.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common.spec("paper_stage1")?)?;
    let options =
        TrackingOptions { starts: args.starts, sets: subject.sets.clone(), limits: !args.no_limits };
    shared(&mut subject, &options, &args.output, |subject, output| {
        score(subject, args.starts, !args.no_limits, output)
    })
}

/// Scores, prints and writes: `starts` perturbed runs per clip, which end at the limits of training or (`limits` false) at a fall
/// only.
pub fn score(
    subject: &mut Subject,
    starts: usize,
    limits: bool,
    output: &Output,
) -> Result<ExitCode, Failure> {
    let options = TrackingOptions { starts, sets: subject.sets.clone(), limits };
    let (monitor, progress) = Progress::start(output.quiet())?;
    subject.setup.monitor = monitor;
    let monitor = subject.setup.monitor.clone();
    if subject.engines == Engines::Both {
        let report = tracking_agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)?;
        let timing = progress.finish();
        if output.nothing(&monitor, &timing) {
            return Ok(ended(&monitor));
        }
        let whole = Evaluation::new("tracking_agreement", &subject.name, &report, timing);
        let tables = [report.builtin.table(), report.mujoco.table(), report.table()];
        output.print(&format!("{}\n{}", tables.join("\n"), timing.text()), &to_json(&whole)?);
        output.write(|out| write_tracking_agreement(out, &report))?;
    } else {
        let report = tracking::evaluate(&subject.setup, &*subject.maker, &options)?;
        let timing = progress.finish();
        if output.nothing(&monitor, &timing) {
            return Ok(ended(&monitor));
        }
        let whole = Evaluation::new("tracking", &subject.name, &report, timing);
        let json = to_json(&whole)?;
        output.print(&format!("{}\n{}", report.table(), timing.text()), &json);
        output.write(|out| write_tracking(out, subject.setup.engine.name(), &report, &json))?;
    }
    output.write(write_report)?;
    Ok(ended(&monitor))
}
