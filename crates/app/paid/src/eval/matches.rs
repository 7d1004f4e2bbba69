//! `paid eval match`.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::episodes::EvalSetup;
use paid_eval::html::write_report;
use paid_eval::matches::{self, Audience, MatchOptions, Spectator};
use paid_eval::results::{Evaluation, to_json, write_match};
use paid_eval::shooting::ROLLING_SPEED;
use paid_eval::subject::Subject;
use paid_plot::{Animation, Film, Kind, film_frame};

use super::engine::{count, positive};
use super::progress::Progress;
use super::subject::Common;
use super::{Output, ended, shared};
use crate::failure::Failure;
use crate::live::LiveArgs;
use crate::ranks;

/// Rate of the film [Hz]: every fourth control step of 50 Hz.
const RATE_HZ: f64 = 12.5;
/// Its size [pixels].
const SIZE: [usize; 2] = [480, 320];

/// Arguments of `paid eval match`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    common: Common,
    /// Kicks per match.
    #[arg(long, default_value_t = 50, value_parser = count)]
    kicks: usize,
    /// Number of matches.
    #[arg(long, default_value_t = 10, value_parser = count)]
    matches: usize,
    /// Balls roll at 0.1 to 0.3 m/s in a random direction instead of lying still.
    #[arg(long)]
    rolling: bool,
    /// Longest time from the clip's end to the next ball [s].
    #[arg(long, hide_short_help = true, value_name = "S", default_value_t = 5.0, value_parser = positive)]
    patience: f64,
    /// Film the first match: a name that ends in .gif or .png, or a folder.
    #[arg(long, value_name = "FILE")]
    film: Option<PathBuf>,
    /// Kicks in the film.
    #[arg(long, hide_short_help = true, value_name = "N", default_value_t = 6, value_parser = count, requires = "film")]
    film_kicks: usize,
    #[command(flatten)]
    output: Output,
    #[command(flatten)]
    live: LiveArgs,
}

/// Plays the matches, writes and prints the report.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.common.setting.one_engine()?;
    if let Some(path) = &args.film
        && Kind::of(path).is_err()
    {
        return Err(Failure::input(format!(
            "--film: expected a name that ends in .gif or .png, or a folder, found {}",
            path.display()
        )));
    }
    let mut subject = Subject::load(&args.common.spec("paper_stage2")?)?;
    subject.require_ball()?;
    let options = MatchOptions {
        kicks: args.kicks,
        matches: args.matches,
        rolling: args.rolling.then_some(ROLLING_SPEED),
        patience_s: args.patience,
        ..MatchOptions::default()
    };
    shared(&mut subject, &options, &args.output, |subject, output| play(args, &options, subject, output))
}

/// Plays them in one process, or a part of them in one of several.
fn play(
    args: &Args,
    options: &MatchOptions,
    subject: &mut Subject,
    output: &Output,
) -> Result<ExitCode, Failure> {
    if args.live.live {
        ranks::alone("--live")?;
    }
    let (monitor, progress) = Progress::start(output.quiet())?;
    subject.setup.monitor = monitor;
    let page = args.live.matches(subject)?;
    let audience = Audience {
        filmed: if args.film.is_some() { args.film_kicks } else { 0 },
        spectator: page.as_ref().map(|page| page as &dyn Spectator),
    };
    let (report, films) = matches::evaluate(&subject.setup, &*subject.maker, options, audience)?;
    let timing = progress.finish();
    let json = to_json(&Evaluation::new("match", &subject.name, &report, timing))?;
    if output.nothing(&subject.setup.monitor, &timing) {
        return Ok(ended(&subject.setup.monitor));
    }
    output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    output.write(|out| {
        write_match(out, subject.setup.engine.name(), &report, &json)?;
        write_report(out)
    })?;
    if let Some(path) = args.film.as_ref().filter(|_| !output.silent) {
        film(&subject.setup, options, &films, path)?;
    }
    Ok(ended(&subject.setup.monitor))
}

/// One kick after the other.
fn film(setup: &EvalSetup, options: &MatchOptions, films: &[Film], path: &Path) -> Result<(), Failure> {
    let ball = Some(setup.preset.ball_params.radius_m);
    let frames = films.iter().map(|film| film.poses.len()).sum();
    let mut animation = Animation::create(path, SIZE, RATE_HZ, frames)?;
    for film in films {
        for t in 0..film.poses.len() {
            animation.add(&film_frame(&setup.robot, film, t, ball, options.goal_half_width_m, SIZE))?;
        }
    }
    Ok(animation.finish()?)
}
