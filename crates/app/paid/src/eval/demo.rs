//! `paid demo`: a policy shoots at the goal from random places, is scored, and is filmed. Without `--policy` it is the one in
//! `policies/demo`, which was trained on the built-in kicks and is part of the program. With `--live` anyone plays with it in a browser.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use paid_eval::episodes::run_episodes;
use paid_eval::html::{REPORT, write_report};
use paid_eval::results::{Evaluation, to_json, write_shooting};
use paid_eval::shooting::{self, Grid, PAPER, ShootingOptions, ShootingReport, Trial, Variant};
use paid_eval::subject::{Subject, SubjectSpec};
use paid_files::write_whole;
use paid_play::POLICY_FILE;
use paid_plot::{Animation, Film, film_frame, film_strip};
use paid_task::InitialState;

use super::engine::count;
use super::out::writable;
use super::policy_file;
use super::progress::Progress;
use super::shoot::{STRIPS, film_worst};
use super::{Output, ended};
use crate::failure::Failure;
use crate::live::LiveArgs;
use crate::threads::thread_count;
use crate::train::motion_folder;

/// The policy that plays when none is given.
const POLICY: &[u8] = include_bytes!("../../../../../policies/demo/policy.onnx");

/// The recording.
const SHOTS: &str = "shots.gif";
/// Frame rate of the recording [Hz].
const RATE_HZ: f64 = 12.5;
/// Size of the recording [pixels].
const SIZE: [usize; 2] = [480, 320];
/// Time limit of a recorded shot [s]: the kick comes after about two, the ball then rolls for as long.
const RECORDED_S: f64 = 4.5;

/// Arguments of `paid demo`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Policy: run folder, checkpoint or ONNX file [default: the built-in one].
    ///
    /// The built-in policy is also written to the output folder.
    #[arg(long, value_name = "POLICY")]
    policy: Option<PathBuf>,
    /// Folder of motion files [default: those the policy was trained on].
    ///
    /// For an ONNX file of another program the default is the built-in kicks.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Shots at each of 63 positions, displaced at random.
    #[arg(long, default_value_t = 4, value_parser = count, conflicts_with = "live")]
    trials: usize,
    /// Shots in the recording.
    #[arg(long, default_value_t = 4, value_parser = count, conflicts_with = "live")]
    record: usize,
    /// Seed of all random numbers.
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Worker threads; the result does not depend on them [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the whole table of the score too.
    #[arg(long, conflicts_with_all = ["live", "json"])]
    table: bool,
    /// Print one line of JSON.
    #[arg(long, conflicts_with = "live")]
    json: bool,
    /// Folder for tables, images, recording and report.
    #[arg(long, value_name = "DIR", default_value = "demo")]
    out: PathBuf,
    #[command(flatten)]
    live: LiveArgs,
}

/// Shoots, writes images and report, and prints the score in three lines.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    args.motions.as_deref().map_or(Ok(()), motion_folder)?;
    let policy = match &args.policy {
        Some(path) => {
            policy_file::check(path)?;
            path.clone()
        }
        None => own_policy(&args.out)?,
    };
    let mut subject = Subject::load(&SubjectSpec {
        motions: args.motions.clone(),
        seed: args.seed,
        threads: thread_count(args.threads)?,
        ..SubjectSpec::new(policy)
    })?;
    subject.require_ball()?;
    if args.live.live {
        return args.live.serve(&subject, None);
    }
    writable("--out", &args.out)?;
    let options = ShootingOptions {
        grid: Grid::EFFECTIVE,
        trials: args.trials,
        variant: Variant::Robot,
        scatter_m: 0.5 * Grid::EFFECTIVE.step,
        ..ShootingOptions::default()
    };
    let (monitor, progress) = Progress::start(args.json)?;
    subject.setup.monitor = monitor;
    let report = shooting::evaluate(&subject.setup, &*subject.maker, &options)?;
    let timing = progress.finish();
    let whole = Evaluation::new("demo", &subject.name, &report, timing);
    let json = to_json(&whole)?;
    let output = Output { json: args.json, ..Output::default() };
    if output.nothing(&subject.setup.monitor, &timing) {
        return Ok(ended(&subject.setup.monitor));
    }
    if args.json || args.table {
        output.print(&format!("{}\n{}\n", report.table(), timing.text()), &json);
    }
    write_shooting(&args.out, subject.setup.engine.name(), &report, &json)?;
    film_worst(&args.out, &subject, &report, STRIPS)?;
    if args.record > 0 && !subject.setup.monitor.stopped() {
        if !args.json {
            eprintln!("recording {} shots", args.record);
        }
        let trials: Vec<&Trial> = report.trials.iter().map(|outcome| &outcome.trial).collect();
        // Evenly over the workspace, whatever their outcome.
        let every = (trials.len() / args.record).max(1);
        let chosen: Vec<InitialState> = trials
            .iter()
            .skip(every / 2)
            .step_by(every)
            .take(args.record)
            .map(|t| shooting::start_of(t))
            .collect();
        record(&subject, &options, &chosen, &args.out)?;
    }
    write_report(&args.out)?;
    if !args.json {
        let recording =
            if args.record > 0 { format!(" and {}", args.out.join(SHOTS).display()) } else { String::new() };
        println!("{}", meaning(&report));
        println!("See {}{recording}. To play, add --live.", args.out.join(REPORT).display());
    }
    Ok(ended(&subject.setup.monitor))
}

/// The score, and what it means.
fn meaning(report: &ShootingReport) -> String {
    let score = &report.total.success;
    let falls = match report.total.falls_ever.count {
        0 => "never fell".to_owned(),
        1 => "fell once".to_owned(),
        count => format!("fell {count} times"),
    };
    let saw = match report.engine.knowledge_name() {
        "truth" => "was given their exact positions",
        _ => "saw them with simulated sensor errors",
    };
    format!(
        "{:.1}% of {} shots scored (95% interval {:.1} to {:.1}%), and the robot {falls}.\n\
         Balls lay up to 2 m ahead; the policy {saw}. The paper's policy: {}%, in MuJoCo.",
        100.0 * score.share,
        score.trials,
        100.0 * score.low,
        100.0 * score.high,
        PAPER[3].1[0][0]
    )
}

/// Writes the program's own policy into `out`, to be played with further; its place.
fn own_policy(out: &Path) -> Result<PathBuf, Failure> {
    let path = out.join(POLICY_FILE);
    write_whole(&path, POLICY)?;
    Ok(path)
}

/// Plays the shots again and draws them: `shots.gif` one after the other, `shot_1.png` and so on as strips.
fn record(
    subject: &Subject,
    options: &ShootingOptions,
    starts: &[InitialState],
    out: &Path,
) -> Result<(), Failure> {
    let setup = &subject.setup;
    let dt_s = setup.preset.control_dt_s();
    let options = ShootingOptions { limit_s: RECORDED_S, ..options.clone() };
    let (rules, steps) = shooting::rules_of(&options, dt_s);
    let films = run_episodes(setup, &*subject.maker, starts, rules, steps, |_| Film::default())?;
    let ball = Some(setup.preset.ball_params.radius_m);
    let half_width = options.goal_half_width_m;
    let every = (1.0 / (RATE_HZ * dt_s)).round().max(1.0) as usize;
    let frames = films.iter().map(|(_, film)| film.poses.len().div_ceil(every)).sum();
    let mut animation = Animation::create(&out.join(SHOTS), SIZE, RATE_HZ, frames)?;
    for (i, film) in &films {
        for t in (0..film.poses.len()).step_by(every) {
            if setup.monitor.stopped() {
                return Ok(());
            }
            let image = film_frame(&setup.robot, film, t, ball, half_width, SIZE);
            animation.add(&image)?;
        }
        let strip = film_strip(&setup.robot, film, dt_s, ball, half_width, 12);
        strip.save(&out.join(format!("shot_{}.png", i + 1)))?;
    }
    Ok(animation.finish()?)
}
