//! `paid eval robustness` and `paid eval terrain`.

use std::process::ExitCode;

use paid_eval::html::write_report;
use paid_eval::results::{Evaluation, to_json, write_robustness};
use paid_eval::robustness::{self, RobustnessOptions, Series};
use paid_eval::shooting::ROLLING_SPEED;

use super::engine::{count, positive};
use super::subject::Common;
use super::{Output, begin_with_ball_in_mujoco, ended};
use crate::failure::Failure;

/// Arguments of both.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Shots at each of the 63 positions of the effective workspace.
    #[arg(long, default_value_t = 1, value_parser = count)]
    trials: usize,
    /// The balls roll.
    #[arg(long)]
    rolling: bool,
    /// Time limit of a trial [s].
    #[arg(long, value_name = "S", default_value_t = 12.0, value_parser = positive)]
    limit: f64,
    #[command(flatten)]
    output: Output,
}

/// Shoots with one thing wrong at a time in MuJoCo, or on one ground after the other, whatever --engine says.
pub fn run(args: &Args, series: Series) -> Result<ExitCode, Failure> {
    if let Some(ground) = args.common.other_ground().filter(|_| series == Series::Terrain) {
        return Err(Failure::input(format!(
            "--ground: expected none, as the grounds are played one after the other, found {}",
            ground.name()
        )));
    }
    let (subject, progress) = begin_with_ball_in_mujoco(&args.common, &args.output)?;
    let options = RobustnessOptions {
        series,
        trials: args.trials,
        rolling: args.rolling.then_some(ROLLING_SPEED),
        limit_s: args.limit,
    };
    let report = robustness::evaluate(&subject.setup, &subject.scene, &*subject.maker, &options)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new(series.name(), &subject.name, &report, timing))?;
    if args.output.nothing(&subject.setup.monitor, &timing) {
        return Ok(ended(&subject.setup.monitor));
    }
    args.output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    args.output.write(|out| {
        write_robustness(out, &report, &json)?;
        write_report(out)
    })?;
    Ok(ended(&subject.setup.monitor))
}
