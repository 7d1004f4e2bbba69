//! `paid eval shooting`.

use std::path::Path;
use std::process::ExitCode;

use paid_eval::EvalError;
use paid_eval::agreement;
use paid_eval::eyes::{self, EyesOptions};
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_agreement, write_eyes, write_shooting, write_summary};
use paid_eval::scene::Engines;
use paid_eval::shooting::{self, Grid, ShootingOptions, ShootingReport};
use paid_eval::subject::Subject;
use paid_eval::worst::{self, write_strips};

use super::eyes::EyesArgs;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::Common;
use super::{Output, ended, shared};
use crate::failure::Failure;
use crate::ranks;

/// Arguments of `paid eval shooting`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Trials per ball place.
    #[arg(long, default_value_t = 50)]
    trials: usize,
    #[command(flatten)]
    protocol: ProtocolArgs,
    #[command(flatten)]
    eyes: EyesArgs,
    /// With --out: the worst N shots of one engine again, as film strips for the report.
    #[arg(long, value_name = "N", default_value_t = STRIPS)]
    strips: usize,
    #[command(flatten)]
    output: Output,
}

/// Film strips of a report unless told otherwise.
pub const STRIPS: usize = 10;

/// Scores in one engine, or in both with a comparison, for each kind of ball.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common.spec("paper_stage2")?)?;
    subject.require_ball()?;
    let kinds = args.protocol.options(args.trials, Grid::WHOLE)?;
    if let Some(options) = args.eyes.options()? {
        ranks::alone("eval shooting --eyes")?;
        return look(&mut subject, &kinds, &options, &args.output);
    }
    shared(&mut subject, &kinds, &args.output, |subject, output| score(subject, &kinds, output, args.strips))
}

/// Scores with the robot's own eyes, one kind of ball after the other.
fn look(
    subject: &mut Subject,
    kinds: &[ShootingOptions],
    eyes: &EyesOptions,
    output: &Output,
) -> Result<ExitCode, Failure> {
    for options in kinds {
        let (monitor, progress) = Progress::start(output.json)?;
        subject.setup.monitor = monitor;
        let (report, kick) = eyes::evaluate(&subject.setup, &*subject.maker, options, eyes)?;
        let timing = progress.finish();
        let whole = Evaluation::new("eyes", &subject.name, &report, timing);
        let json = to_json(&whole)?;
        output.write(|out| write_eyes(out, &report, kick.as_ref(), &json))?;
        output.print(&format!("{}\n{}", report.table(), timing.text()), &json);
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    if let Some(out) = &output.out {
        write_report(out)?;
    }
    Ok(ended(&subject.setup.monitor))
}

/// Scores, writes and prints one kind of ball after the other.
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
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    if let Some(out) = output.folder() {
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

/// One kind of ball: runs, writes, prints, and returns the report of each engine.
fn one(
    subject: &mut Subject,
    options: &ShootingOptions,
    output: &Output,
    strips: usize,
) -> Result<Vec<(&'static str, ShootingReport)>, Failure> {
    let (monitor, progress) = Progress::start(output.quiet())?;
    subject.setup.monitor = monitor;
    let (text, json, reports) = if subject.engines == Engines::Both {
        let report = agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, options)?;
        let timing = progress.finish();
        output.write(|out| write_agreement(out, &report))?;
        let whole = Evaluation::new("agreement", &subject.name, &report, timing);
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        (text, json, vec![("builtin", report.builtin), ("mujoco", report.mujoco)])
    } else {
        let report = shooting::evaluate(&subject.setup, &*subject.maker, options)?;
        let timing = progress.finish();
        let whole = Evaluation::new("shooting", &subject.name, &report, timing);
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        let engine = subject.setup.engine.name();
        output.write(|out| {
            write_shooting(out, engine, &report, &json)?;
            film_worst(out, subject, &report, strips)
        })?;
        (text, json, vec![(engine, report)])
    };
    output.print(&text, &json);
    Ok(reports)
}
