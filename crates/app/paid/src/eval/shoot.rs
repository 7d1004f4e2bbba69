//! `paid eval shooting`.

use std::path::Path;
use std::process::ExitCode;

use paid_eval::EvalError;
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_shooting, write_summary};
use paid_eval::scene::Engines;
use paid_eval::share;
use paid_eval::shooting::{self, Grid, ShootingOptions, ShootingReport};
use paid_eval::subject::Subject;
use paid_eval::worst::{self, write_strips};
use paid_lab::agreement;
use paid_lab::results::write_agreement;

use super::engine::count;
use super::eyes::EyesArgs;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::Common;
use super::{Output, ended, shared};
use crate::failure::Failure;

/// Arguments of `paid eval shooting`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Shots per ball position.
    #[arg(long, default_value_t = 50, value_parser = count)]
    trials: usize,
    #[command(flatten)]
    protocol: ProtocolArgs,
    #[command(flatten)]
    eyes: EyesArgs,
    /// With --out: film strips of the worst N shots, for the report [default: 10].
    ///
    /// The shots are played again, in one engine.
    #[arg(long, hide_short_help = true, help_heading = "Output", value_name = "N", value_parser = count, requires = "out", conflicts_with = "eyes")]
    strips: Option<usize>,
    #[command(flatten)]
    output: Output,
}

/// Default number of film strips in a report.
pub const STRIPS: usize = 10;

/// Scores in one engine, or in both with a comparison, for each kind of ball.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common.spec("paper_stage2")?)?;
    subject.require_ball()?;
    let kinds = args.protocol.options(args.trials, Grid::WHOLE)?;
    if let Some(ended) = args.eyes.run(&mut subject, &kinds, &args.output)? {
        return Ok(ended);
    }
    let strips = args.strips.unwrap_or(STRIPS);
    shared(&mut subject, &kinds, &args.output, |subject, output| score(subject, &kinds, output, strips))
}

/// Scores, prints and writes one kind of ball after the other.
pub fn score(
    subject: &mut Subject,
    kinds: &[ShootingOptions],
    output: &Output,
    strips: usize,
) -> Result<ExitCode, Failure> {
    // Reports of each engine, for the figure of all kinds of ball.
    let mut reports: Vec<(&'static str, Vec<ShootingReport>)> = Vec::new();
    for options in kinds {
        for (engine, report) in one(subject, options, output, strips)? {
            match reports.iter_mut().find(|(name, _)| *name == engine) {
                Some((_, of)) => of.push(report),
                None => reports.push((engine, vec![report])),
            }
        }
        if share::stopped(&*subject.setup.ranks, &subject.setup.monitor) {
            break;
        }
    }
    if let Some(out) = output.folder().filter(|_| !reports.is_empty()) {
        for (engine, of) in &reports {
            write_summary(out, engine, of)?;
        }
        write_report(out)?;
    }
    if !output.quiet() {
        for (_, of) in reports.iter().filter(|(_, of)| of.len() > 1) {
            println!("\n{}", shooting::summary(of));
        }
    }
    Ok(ended(&subject.setup.monitor))
}

/// Writes the film strips of a whole report's worst shots.
pub fn film_worst(
    out: &Path,
    subject: &Subject,
    report: &ShootingReport,
    strips: usize,
) -> Result<(), EvalError> {
    if strips == 0 || subject.setup.monitor.stopped() {
        return Ok(());
    }
    let stem = format!("{}_{}", subject.setup.engine.name(), report.ball());
    write_strips(out, &stem, &worst::strips(&subject.setup, &*subject.maker, report, strips)?)
}

/// One kind of ball: runs, prints, writes, and returns the report of each engine; none if it was stopped before the first trial.
fn one(
    subject: &mut Subject,
    options: &ShootingOptions,
    output: &Output,
    strips: usize,
) -> Result<Vec<(&'static str, ShootingReport)>, Failure> {
    let (monitor, progress) = Progress::start(output.quiet())?;
    subject.setup.monitor = monitor;
    let monitor = subject.setup.monitor.clone();
    if subject.engines == Engines::Both {
        let report = agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, options)?;
        let timing = progress.finish();
        if output.nothing(&monitor, &timing) {
            return Ok(Vec::new());
        }
        let json = to_json(&Evaluation::new("agreement", &subject.name, &report, timing))?;
        output.print(&format!("{}\n{}", report.table(), timing.text()), &json);
        output.write(|out| write_agreement(out, &report))?;
        Ok(vec![("builtin", report.builtin), ("mujoco", report.mujoco)])
    } else {
        let report = shooting::evaluate(&subject.setup, &*subject.maker, options)?;
        let timing = progress.finish();
        if output.nothing(&monitor, &timing) {
            return Ok(Vec::new());
        }
        let json = to_json(&Evaluation::new("shooting", &subject.name, &report, timing))?;
        output.print(&format!("{}\n{}", report.table(), timing.text()), &json);
        let engine = subject.setup.engine.name();
        output.write(|out| {
            write_shooting(out, engine, &report, &json)?;
            film_worst(out, subject, &report, strips)
        })?;
        Ok(vec![(engine, report)])
    }
}
