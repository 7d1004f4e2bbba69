//! `paid eval panel`.

use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::panel::{self, PanelOptions};
use paid_eval::results::{Evaluation, to_json, write_panel};
use paid_eval::shooting::ROLLING_SPEED;

use super::engine::{count, positive};
use super::protocol::Ball;
use super::subject::Common;
use super::{Output, begin_with_ball_in_mujoco, ended};
use crate::failure::Failure;

/// Arguments of `paid eval panel`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Shots at each of the 63 positions of the effective workspace.
    #[arg(long, default_value_t = 1, value_parser = count)]
    trials: usize,
    /// How the balls move.
    #[arg(long, value_enum, default_value = "both")]
    ball: Ball,
    /// Time limit of a trial [s].
    #[arg(long, value_name = "S", default_value_t = 12.0, value_parser = positive)]
    limit: f64,
    /// Other balls and other trials, for final scores: never choose anything by them.
    #[arg(long)]
    held_out: bool,
    #[command(flatten)]
    output: Output,
}

/// Runs the panel in MuJoCo, whatever --engine says.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    if let Some(key) = args.common.set_by_panel() {
        return Err(Failure::input(format!(
            "--scene: expected no {key}, as the panel has its own balls and grounds, found one"
        )));
    }
    let (subject, progress) = begin_with_ball_in_mujoco(&args.common, &args.output)?;
    let rolling = Some(ROLLING_SPEED);
    let balls = match args.ball {
        Ball::Static => vec![None],
        Ball::Rolling => vec![rolling],
        Ball::Both => vec![None, rolling],
    };
    let options = PanelOptions {
        trials: args.trials,
        balls,
        limit_s: args.limit,
        held_out: args.held_out,
        ..PanelOptions::default()
    };
    let report = panel::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new("panel", &subject.name, &report, timing))?;
    if args.output.nothing(&subject.setup.monitor, &timing) {
        return Ok(ended(&subject.setup.monitor));
    }
    args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    args.output.write(|out| {
        write_panel(out, &report, &json)?;
        write_report(out)
    })?;
    Ok(ended(&subject.setup.monitor))
}
