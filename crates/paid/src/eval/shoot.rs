//! `paid eval shooting`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::agreement::{self, AgreementReport};
use paid_eval::file::write_whole;
use paid_eval::html::write_report;
use paid_eval::shooting::{self, Grid, ShootingOptions, ShootingReport};

use super::engine::EngineName;
use super::progress::Progress;
use super::protocol::ProtocolArgs;
use super::subject::{Common, Subject};
use super::{Whole, ended, to_json};
use crate::failure::Failure;

/// Arguments of `paid eval shooting`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Trials a ball place.
    #[arg(long, default_value_t = 50)]
    trials: usize,
    #[command(flatten)]
    protocol: ProtocolArgs,
    /// Print one line of JSON a kind of ball.
    #[arg(long)]
    json: bool,
    /// Write JSON, a CSV row a trial, heat maps, paths and report.html to this folder.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
}

/// Scores in one engine, or in both with a comparison, for each kind of ball.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let mut subject = Subject::load(&args.common, "stage2")?;
    subject.needs_ball()?;
    let kinds = args.protocol.options(args.trials, Grid::WHOLE)?;
    subject.setup.engine = subject.engine(args.common.setting.engine);
    // Reports of each engine, for the figure of all kinds of ball.
    let mut reports: Vec<(&'static str, Vec<ShootingReport>)> = Vec::new();
    for options in &kinds {
        for (engine, report) in one(args, &mut subject, options)? {
            match reports.iter_mut().find(|(name, _)| *name == engine) {
                Some((_, of)) => of.push(report),
                None => reports.push((engine, vec![report])),
            }
        }
        if subject.setup.monitor.stopped() {
            break;
        }
    }
    if let Some(out) = &args.out {
        for (engine, of) in &reports {
            if of.len() > 1 {
                let table = out.join(format!("{engine}_summary.txt"));
                write_whole(&table, shooting::summary(of).as_bytes()).map_err(Failure::input)?;
                let stem = out.join(format!("{engine}_summary_panels"));
                shooting::panels(of).save(&stem).map_err(Failure::input)?;
            }
        }
        write_report(out).map_err(Failure::input)?;
    }
    if !args.json {
        for (_, of) in reports.iter().filter(|(_, of)| of.len() > 1) {
            println!("\n{}", shooting::summary(of));
        }
    }
    Ok(ended(&subject.setup.monitor))
}

/// One kind of ball: runs, writes, prints, and returns the report of each engine.
fn one(
    args: &Args,
    subject: &mut Subject,
    options: &ShootingOptions,
) -> Result<Vec<(&'static str, ShootingReport)>, Failure> {
    let (monitor, progress) = Progress::start(args.json)?;
    subject.setup.monitor = monitor;
    let (text, json, reports) = if args.common.setting.engine == EngineName::Both {
        let report = agreement::evaluate(&subject.setup, &subject.scene, &*subject.maker, options)
            .map_err(Failure::input)?;
        let timing = progress.finish();
        if let Some(out) = &args.out {
            write_agreement(out, &report)?;
        }
        let whole = Whole { kind: "agreement", policy: &subject.name, report: &report, timing };
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        (text, json, vec![("builtin", report.builtin), ("mujoco", report.mujoco)])
    } else {
        let report = shooting::evaluate(&subject.setup, &*subject.maker, options).map_err(Failure::input)?;
        let timing = progress.finish();
        let whole = Whole { kind: "shooting", policy: &subject.name, report: &report, timing };
        let (text, json) = (format!("{}\n{}", report.table(), timing.text()), to_json(&whole)?);
        let engine = subject.setup.engine.name();
        if let Some(out) = &args.out {
            write_shooting(out, engine, &report, &json)?;
        }
        (text, json, vec![(engine, report)])
    };
    println!("{}", if args.json { json } else { text });
    Ok(reports)
}

fn write_agreement(out: &Path, report: &AgreementReport) -> Result<(), Failure> {
    let kind = report.builtin.ball();
    write_shooting(out, "builtin", &report.builtin, &to_json(&report.builtin)?)?;
    write_shooting(out, "mujoco", &report.mujoco, &to_json(&report.mujoco)?)?;
    let csv = out.join(format!("both_{kind}_trials.csv"));
    write_whole(&csv, report.csv().as_bytes()).map_err(Failure::input)?;
    let text = out.join(format!("both_{kind}.txt"));
    write_whole(&text, report.table().as_bytes()).map_err(Failure::input)
}

pub fn write_shooting(out: &Path, engine: &str, report: &ShootingReport, json: &str) -> Result<(), Failure> {
    let kind = report.ball();
    let file = |what: &str| out.join(format!("{engine}_{kind}_{what}"));
    write_whole(&file("shooting.json"), json.as_bytes()).map_err(Failure::input)?;
    write_whole(&file("trials.csv"), report.csv().as_bytes()).map_err(Failure::input)?;
    let table = out.join(format!("{engine}_{kind}.txt"));
    write_whole(&table, report.table().as_bytes()).map_err(Failure::input)?;
    for (name, map) in report.maps() {
        map.figure().save(&file(name)).map_err(Failure::input)?;
    }
    report.paths().save(&file("paths")).map_err(Failure::input)
}
