//! `paid eval shooting`.

use std::process::ExitCode;

use paid_eval::agreement;
use paid_eval::eyes::{self, EyesOptions};
use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_agreement, write_eyes, write_shooting, write_summary};
use paid_eval::scene::Engines;
use paid_eval::shooting::{self, Grid, ShootingOptions, ShootingReport};
use paid_eval::subject::Subject;

use super::eyes::EyesArgs;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::Common;
use super::{Output, ended};
use crate::failure::Failure;

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
    #[command(flatten)]
    output: Output,
}

/// Scores in one engine, or in both with a comparison, for each kind of ball.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common.spec("paper_stage2")?)?;
    subject.require_ball()?;
    let kinds = args.protocol.options(args.trials, Grid::WHOLE)?;
    if let Some(options) = args.eyes.options()? {
        return look(&mut subject, &kinds, &options, &args.output);
    }
    score(&mut subject, &kinds, &args.output)
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
        let whole = Evaluation { kind: "eyes", policy: &subject.name, report: &report, timing };
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
pub fn score(subject: &mut Subject, kinds: &[ShootingOptions], output: &Output) -> Result<ExitCode, Failure> {
    // Reports of each engine, for the figure of all kinds of ball.
    let mut reports: Vec<(&'static str, Vec<ShootingReport>)> = Vec::new();
    for options in kinds {
        for (engine, report) in one(subject, options, output)? {
            match reports.iter_mut().find(|(name, _)| *name == engine) {
                Some((_, of)) => of.push(report),
                None => reports.push((engine, vec![report])),
            }
        }
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    if let Some(out) = &output.out {
        for (engine, of) in &reports {
            write_summary(out, engine, of)?;
        }
        write_report(out)?;
    }
    if !output.json {
        for (_, of) in reports.iter().filter(|(_, of)| of.len() > 1) {
            println!("\n{}", shooting::summary(of));
        }
    }
    Ok(ended(&subject.setup.monitor))
}

/// One kind of ball: runs, writes, prints, and returns the report of each engine.
fn one(
    subject: &mut Subject,
    options: &ShootingOptions,
    output: &Output,
) -> Result<Vec<(&'static str, ShootingReport)>, Failure> {
    let (monitor, progress) = Progress::start(output.json)?;
    subject.setup.monitor = monitor;
    let (text, json, reports) = if subject.engines == Engines::Both {
        let report = agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, options)?;
        let timing = progress.finish();
        output.write(|out| write_agreement(out, &report))?;
        let whole = Evaluation { kind: "agreement", policy: &subject.name, report: &report, timing };
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        (text, json, vec![("builtin", report.builtin), ("mujoco", report.mujoco)])
    } else {
        let report = shooting::evaluate(&subject.setup, &*subject.maker, options)?;
        let timing = progress.finish();
        let whole = Evaluation { kind: "shooting", policy: &subject.name, report: &report, timing };
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        let engine = subject.setup.engine.name();
        output.write(|out| write_shooting(out, engine, &report, &json))?;
        (text, json, vec![(engine, report)])
    };
    output.print(&text, &json);
    Ok(reports)
}
