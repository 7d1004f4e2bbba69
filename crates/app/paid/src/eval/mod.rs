//! `paid eval`: scores a policy and draws what it does.

mod clips;
mod contacts;
pub mod demo;
mod engine;
pub mod episode;
#[cfg_attr(not(feature = "full"), path = "no_eyes.rs")]
mod eyes;
mod film;
mod lag;
mod likeness;
mod matches;
pub mod out;
mod panel;
mod policy_file;
pub mod progress;
mod protocol;
mod robustness;
pub mod shoot;
pub mod subject;
pub mod track;

use std::fmt::Debug;
use std::path::Path;
use std::process::ExitCode;
use std::sync::Arc;

use paid_eval::monitor::Monitor;
use paid_eval::robustness::Series;
use paid_eval::scene::Engines;
use paid_eval::subject::Subject;
use paid_terminal::STOPPED;
use paid_train::TrainError;
use paid_train::meeting::{Introduction, meet};

use crate::failure::Failure;
use crate::ranks;

pub use out::Output;
use progress::Progress;
use subject::Common;

/// Arguments of `paid eval`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Measure how closely the policy follows each motion.
    Tracking(track::Args),
    /// Shoot at the goal from a grid of ball positions.
    Shooting(Box<shoot::Args>),
    /// Kick ball after ball without a reset: kicks until the first fall, goals, drift.
    Match(Box<matches::Args>),
    /// Compare the kicks with the clips: jerk, joint angles, foot path, swing of arms and legs.
    Likeness(Box<likeness::Args>),
    /// Measure how late the joints follow their targets.
    Lag(Box<lag::Args>),
    /// Shoot with each clip at balls near its own ball.
    Clips(Box<clips::Args>),
    /// Measure when the foot hits the ball in each motion, to predict rolling balls.
    ///
    /// A rolling ball is predicted for that moment.
    Contacts(Box<contacts::Args>),
    /// Shoot in MuJoCo with eleven combinations of ball and ground.
    ///
    /// Hollow and solid, light and heavy, dead and bouncing, slippery and gripping balls, on turf and in a hall, and one that
    /// bounces as a filmed match ball.
    Panel(Box<panel::Args>),
    /// Shoot in MuJoCo with one thing wrong at a time: pushes, payload, weak knee, late targets, slippery floor.
    Robustness(Box<robustness::Args>),
    /// Shoot in MuJoCo on one ground after the other: flat, rough, sloping, turf, hard.
    Terrain(Box<robustness::Args>),
    /// Draw one episode.
    Film(film::Args),
    /// Write the evaluation's scene for MuJoCo's viewer, or print its settings.
    Scene(engine::SceneArgs),
}

/// Runs a subcommand.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    let spread = matches!(args.command, Command::Tracking(_) | Command::Shooting(_) | Command::Match(_));
    if !spread {
        ranks::alone("this evaluation (tracking, shooting and match take several)")?;
    }
    match args.command {
        Command::Tracking(args) => track::run(&args),
        Command::Shooting(args) => shoot::run(&args),
        Command::Match(args) => matches::run(&args),
        Command::Clips(args) => clips::run(&args),
        Command::Contacts(args) => contacts::run(&args),
        Command::Likeness(args) => likeness::run(&args),
        Command::Lag(args) => lag::run(&args),
        Command::Panel(args) => panel::run(&args),
        Command::Robustness(args) => robustness::run(&args, Series::Robustness),
        Command::Terrain(args) => robustness::run(&args, Series::Terrain),
        Command::Film(args) => film::run(&args).map(|()| ExitCode::SUCCESS),
        Command::Scene(args) => engine::write_scene(&args).map(|()| ExitCode::SUCCESS),
    }
}

/// Does `work` with a part of the subject's trials, where `mpirun` has started several processes; the first one writes and prints. All of
/// them must have the same `options` and the same subject.
fn shared(
    subject: &mut Subject,
    options: &dyn Debug,
    output: &Output,
    work: impl FnOnce(&mut Subject, &Output) -> Result<ExitCode, Failure>,
) -> Result<ExitCode, Failure> {
    ranks::together(|joined| {
        subject.setup.ranks = Arc::clone(&joined.ranks);
        if joined.ranks.count() > 1 && subject.engines == Engines::Both {
            return Err(Failure::input(
                "mpirun: expected one engine (--engine builtin or mujoco), found both",
            ));
        }
        meet(&*joined.ranks, |own| introduce(own, subject, options))?;
        let output = Output { silent: !joined.is_first(), ..output.clone() };
        output.prepare()?;
        if let Some(text) = subject.doubts.as_ref().filter(|_| joined.is_first()) {
            eprintln!("note: motions: {text}");
        }
        work(subject, &output)
    })
}

/// What must be equal on all processes.
fn introduce(own: &mut Introduction, subject: &Subject, options: &dyn Debug) -> Result<(), TrainError> {
    let setup = &subject.setup;
    own.tell("instruction set", setup.isa);
    own.tell("seed", setup.seed);
    own.tell("engine", setup.engine.name());
    own.tell_options(options);
    own.tell_options(&subject.scene);
    own.tell_options(&setup.preset);
    let policy = Path::new(&subject.name);
    if policy.is_file() {
        own.tell_file("policy", policy)?;
    }
    own.tell_robot(&(&setup.robot, &setup.spec));
    own.tell_motions(&setup.library);
    Ok(())
}

/// The subject of an evaluation with a ball in one engine, and its progress. Nothing is left to fail but the evaluation.
fn begin_with_ball(common: &Common, output: &Output) -> Result<(Subject, Progress), Failure> {
    common.setting.one_engine()?;
    let mut subject = Subject::load(&common.spec("paper_stage2")?)?;
    subject.require_ball()?;
    let progress = begin(&mut subject, output)?;
    Ok((subject, progress))
}

/// The same for an evaluation that is in MuJoCo, whatever --engine says.
fn begin_with_ball_in_mujoco(common: &Common, output: &Output) -> Result<(Subject, Progress), Failure> {
    let mut subject = Subject::load(&common.spec_of_referee("paper_stage2")?)?;
    subject.require_ball()?;
    Engines::Mujoco.check()?;
    let progress = begin(&mut subject, output)?;
    Ok((subject, progress))
}

/// Prepares the output and watches the subject's trials.
fn begin(subject: &mut Subject, output: &Output) -> Result<Progress, Failure> {
    output.prepare()?;
    let (monitor, progress) = Progress::start(output.json)?;
    subject.setup.monitor = monitor;
    Ok(progress)
}

/// The exit code of an evaluation that ran to its end or was stopped.
fn ended(monitor: &Monitor) -> ExitCode {
    if monitor.stopped() { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS }
}
