//! `paid train`: Stage I, Stage II from it, then the evaluation; or one stage.

mod clips;
mod printer;
mod values;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use clap::ValueEnum;
use paid_eval::EvalError;
use paid_eval::contacts;
use paid_eval::curves::Curves;
use paid_eval::judge::MujocoJudge;
use paid_eval::shooting::{Grid, ROLLING_SPEED, ShootingOptions};
use paid_eval::subject::{Subject, SubjectSpec};
use paid_files::write_whole;
use paid_live::TrainingPage;
use paid_play::{POLICY_FILE, PRESET_FILE};
use paid_task::TaskPreset;
use paid_terminal::{STOPPED, flag};
use paid_train::folder::forget_unsaved;
use paid_train::meeting::meet;
use paid_train::{
    Comparer, End, Explanation, Judge, Limits, Outcome, Record, Resolved, StageJob, Start, train_judged_stage,
};
use printer::Printer;

use crate::eval::{Output, shoot, track};
use crate::failure::Failure;
use crate::live::LiveArgs;
use crate::ranks::{self, Joined};
use crate::threads::{thread_count, without_work};

pub use values::{motion_folder, motions_value, whole};

/// Arguments of `paid train`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Stage to train [default: both, then the evaluation].
    #[arg(value_enum)]
    stage: Option<Stage>,
    /// Run preset, built in or a file; needs a stage [default: the stage's].
    #[arg(long, value_name = "NAME|FILE", requires = "stage")]
    preset: Option<String>,
    /// Run preset of Stage I when both stages are trained [default: stage1].
    #[arg(long, hide_short_help = true, value_name = "NAME|FILE", conflicts_with = "stage")]
    stage1_preset: Option<String>,
    /// Run preset of Stage II when both stages are trained [default: stage2].
    #[arg(long, hide_short_help = true, value_name = "NAME|FILE", conflicts_with = "stage")]
    stage2_preset: Option<String>,
    /// Start from this policy: a run folder or a checkpoint; needs a stage.
    ///
    /// Of a run folder, the mean of its last checkpoints is taken. The policy's action noise is kept, except where Stage II starts from a
    /// Stage I policy: there the preset's applies. A preset with a [teacher] can also start from a policy file, with the preset's noise.
    #[arg(long, value_name = "RUN", requires = "stage", conflicts_with = "resume")]
    from: Option<PathBuf>,
    /// Continue the run in the output folder from its last checkpoint.
    ///
    /// Its remaining phases are spread over the remaining iterations, or over --minutes.
    #[arg(long)]
    resume: bool,
    /// Folder of motion files [default: the built-in kicks].
    ///
    /// Files end in .npz, .csv or .pkl, and are searched recursively.
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Output folder [default: runs/stage1, runs/stage2, or runs for both].
    ///
    /// Both stages go to the folders stage1 and stage2 in it.
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Stop after this time [min]; of two stages the first takes at most 65%.
    #[arg(long, value_name = "M")]
    minutes: Option<f64>,
    /// Iterations of each stage [default: the preset's].
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Worker threads; the result does not depend on them [default: all cores].
    #[arg(long, hide_short_help = true, value_name = "N")]
    threads: Option<usize>,
    /// Change a preset value, such as learn.ppo.epochs=5 (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    /// Print each preset value and its origin, and train nothing.
    ///
    /// The origin is a file and line, --set or the default in the code; the values that the phases set follow.
    #[arg(long, conflicts_with = "quiet")]
    explain: bool,
    /// Print each iteration, or the explanation, as a line of JSON.
    #[arg(long, conflicts_with = "quiet")]
    json: bool,
    /// Print errors only.
    #[arg(long)]
    quiet: bool,
    #[command(flatten)]
    live: LiveArgs,
}

/// The share of the wall clock that Stage I may use where there are two.
const STAGE1_SHARE: f64 = 0.65;

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Stage {
    /// Follow the motions.
    Stage1,
    /// Kick the ball.
    Stage2,
}

impl Stage {
    fn name(self) -> &'static str {
        match self {
            Self::Stage1 => "stage1",
            Self::Stage2 => "stage2",
        }
    }

    /// Refuses a task of the other stage; `place` says where it comes from.
    fn check(self, place: &str, task: &TaskPreset) -> Result<(), Failure> {
        match (self, task.scene.ball) {
            (Self::Stage1, false) | (Self::Stage2, true) => Ok(()),
            (Self::Stage1, true) => Err(Failure::input(format!(
                "{place}: Stage I follows motions without a ball; expected task.scene.ball = false, found true, which is for \
                 `paid train stage2`"
            ))),
            (Self::Stage2, false) => Err(Failure::input(format!(
                "{place}: Stage II kicks a ball; expected task.scene.ball = true, found false"
            ))),
        }
    }
}

impl Args {
    /// The run preset that was asked for `stage`, with the option that asked for it.
    fn preset_of(&self, stage: Stage) -> Option<(&'static str, &str)> {
        let of_both = match stage {
            Stage::Stage1 => ("--stage1-preset", &self.stage1_preset),
            Stage::Stage2 => ("--stage2-preset", &self.stage2_preset),
        };
        [("--preset", &self.preset), of_both]
            .into_iter()
            .find_map(|(option, preset)| Some((option, preset.as_deref()?)))
    }

    /// The values of a run of `stage` in `out`.
    fn resolve(&self, stage: Stage, start: &Start, out: &Path) -> Result<Resolved, Failure> {
        let mut sets = whole(&self.sets)?;
        if let Some(motions) = &self.motions {
            motion_folder(motions)?;
            sets.push(motions_value(motions));
        }
        if let Some(iterations) = self.iterations {
            sets.push(format!("run.iterations={iterations}"));
        }
        let asked = self.preset_of(stage);
        if matches!(start, Start::Resume) {
            return match asked {
                None => {
                    let resolved = Resolved::of_run(out, &sets).map_err(Failure::input)?;
                    let place = format!("--resume: the run in {}", out.display());
                    stage.check(&place, &resolved.preset.task)?;
                    Ok(resolved)
                }
                Some((option, name)) => Err(Failure::input(format!(
                    "{option} {name}: the run in {} has a preset; change its values with --set",
                    out.display()
                ))),
            };
        }
        let (option, name) = asked.unwrap_or(("--preset", stage.name()));
        let resolved = Resolved::load(name, &sets, "").map_err(Failure::input)?;
        stage.check(&format!("{option} {name}"), &resolved.preset.task)?;
        Ok(resolved)
    }

    /// Prints every value of a stage and where it comes from.
    fn explain(&self, stage: Stage, start: &Start, out: &Path) -> Result<(), Failure> {
        let resolved = self.resolve(stage, start, out)?;
        let explanation = Explanation::of(&resolved).map_err(Failure::input)?;
        if self.json {
            println!("{}", serde_json::to_string(&explanation).map_err(Failure::input)?);
        } else {
            print!("{explanation}");
        }
        Ok(())
    }
}

/// Trains, prints progress, and ends with 0 when the budget is used up or 130 after Ctrl-C. Of several processes the first one writes,
/// prints and scores.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    ranks::together(|joined| train(args, joined))
}

fn train(args: Args, joined: &Joined) -> Result<ExitCode, Failure> {
    if args.minutes.is_some_and(|m| !(m > 0.0 && m.is_finite())) {
        return Err(Failure::input(format!(
            "--minutes: expected a positive number, found {}",
            args.minutes.unwrap_or_default()
        )));
    }
    thread_count(args.threads)?;
    let stop = flag()?;
    if let Some(stage) = args.stage {
        let out = args.out.clone().unwrap_or_else(|| Path::new("runs").join(stage.name()));
        let start = match (&args.from, args.resume) {
            (_, true) => Start::Resume,
            (Some(from), _) => Start::From(from.clone()),
            (None, false) => Start::Fresh,
        };
        if args.explain {
            if joined.is_first() {
                args.explain(stage, &start, &out)?;
            }
            return Ok(ExitCode::SUCCESS);
        }
        if joined.is_first() && !matches!(start, Start::Resume) {
            clips::look_at(&[args.resolve(stage, &start, &out)?.preset], args.quiet)?;
        }
        let watched = Watched { joined, page: page(&args, joined) };
        let outcome = run_stage(&args, stage, start, out, args.minutes, &stop, &watched)?;
        return Ok(exit_code(&outcome));
    }
    let out = args.out.clone().unwrap_or_else(|| PathBuf::from("runs"));
    let begun = |stage: Stage| out.join(stage.name()).join(PRESET_FILE).exists();
    let any = [Stage::Stage1, Stage::Stage2].into_iter().any(begun);
    // All ranks have looked before the first one removes anything.
    meet(&*joined.ranks, |own| {
        own.tell("resume", args.resume);
        own.tell("explain", args.explain);
        Ok(())
    })?;
    if args.resume && !any {
        let out = out.display();
        return Err(Failure::input(format!(
            "--resume: expected a run in {out}/stage1 or {out}/stage2, found none"
        )));
    }
    if args.resume && !args.explain {
        for stage in [Stage::Stage1, Stage::Stage2].into_iter().filter(|_| joined.is_first()) {
            let folder = out.join(stage.name());
            if forget_unsaved(&folder)? {
                eprintln!(
                    "note: the run in {} has no checkpoint yet and starts from scratch",
                    folder.display()
                );
            }
        }
        // The others look again when that is done.
        joined.ranks.gather(&[]);
    }
    // Stage II begins when Stage I is over, so there is nothing of it to resume then.
    let stages: &[(Stage, f64)] = if args.resume && begun(Stage::Stage2) {
        &[(Stage::Stage2, 1.0)]
    } else {
        &[(Stage::Stage1, STAGE1_SHARE), (Stage::Stage2, 1.0)]
    };
    if args.explain {
        for &(stage, _) in stages.iter().filter(|_| joined.is_first()) {
            let start = if args.resume && begun(stage) { Start::Resume } else { Start::Fresh };
            args.explain(stage, &start, &out.join(stage.name()))?;
        }
        return Ok(ExitCode::SUCCESS);
    }
    // A mistake in a stage that starts is reported now: in Stage II's not after Stage I, and once where both have it.
    let starting = stages.iter().filter(|(stage, _)| !(args.resume && begun(*stage)));
    let presets = starting.map(|&(stage, _)| Ok(args.resolve(stage, &Start::Fresh, &out)?.preset));
    let presets = presets.collect::<Result<Vec<_>, Failure>>()?;
    if joined.is_first() {
        clips::look_at(&presets, args.quiet)?;
    }
    let watched = Watched { joined, page: page(&args, joined) };
    let clock = Instant::now();
    let mut previous: Option<PathBuf> = None;
    for &(stage, share) in stages {
        let folder = out.join(stage.name());
        let start = match previous.take() {
            _ if args.resume && begun(stage) => Start::Resume,
            None => Start::Fresh,
            Some(run) => Start::From(run),
        };
        // Stage II has all that Stage I leaves, also where its iterations end before its minutes.
        let minutes = args.minutes.map(|all| share * (all - clock.elapsed().as_secs_f64() / 60.0).max(0.0));
        let outcome = run_stage(&args, stage, start, folder.clone(), minutes, &stop, &watched)?;
        if outcome.end == End::Stopped {
            return Ok(exit_code(&outcome));
        }
        previous = Some(folder);
    }
    if joined.is_first() { score(&args, &out, &stop) } else { Ok(ExitCode::SUCCESS) }
}

/// Shots per ball place after both stages.
const SHOTS: usize = 10;

/// Scores both stages: the first follows the motions, the second shoots at static and rolling balls of the effective workspace. The
/// files go to `out/eval`. Once `stop` is set the rest is left out.
fn score(args: &Args, out: &Path, stop: &AtomicBool) -> Result<ExitCode, Failure> {
    let output = Output { json: args.json, out: Some(out.join("eval")), silent: false, mute: args.quiet };
    let load = |stage: Stage| -> Result<Subject, Failure> {
        let spec =
            SubjectSpec { threads: thread_count(args.threads)?, ..SubjectSpec::new(out.join(stage.name())) };
        Ok(Subject::load(&spec)?)
    };
    write_course(out, &out.join("eval"))?;
    let code = track::score(&mut load(Stage::Stage1)?, track::STARTS, true, &output)?;
    if stop.load(Ordering::SeqCst) {
        return Ok(code);
    }
    let balls = [None, Some(ROLLING_SPEED)].map(|rolling| ShootingOptions {
        grid: Grid::EFFECTIVE,
        trials: SHOTS,
        rolling,
        ..ShootingOptions::default()
    });
    let mut kicker = load(Stage::Stage2)?;
    kicker.require_ball()?;
    shoot::score(&mut kicker, &balls, &output, shoot::STRIPS)
}

/// Writes both stages' curves, for the page.
fn write_course(out: &Path, eval: &Path) -> Result<(), Failure> {
    let mut lines = String::new();
    for stage in [Stage::Stage1, Stage::Stage2] {
        let curves = Curves::read(&out.join(stage.name()))?;
        lines.push_str(&curves.summary());
        lines.push('\n');
        curves.figure().save(&eval.join(format!("training_{}", stage.name())))?;
    }
    Ok(write_whole(&eval.join("training.txt"), lines.as_bytes())?)
}

fn exit_code(outcome: &Outcome) -> ExitCode {
    if outcome.end == End::Stopped { ExitCode::from(STOPPED) } else { ExitCode::SUCCESS }
}

/// The processes that train, and the page that shows it.
struct Watched<'a> {
    joined: &'a Joined,
    page: Option<TrainingPage>,
}

/// The page, if it was asked for. Of several processes the first one serves it.
fn page(args: &Args, joined: &Joined) -> Option<TrainingPage> {
    joined.is_first().then(|| args.live.training()).flatten()
}

fn run_stage(
    args: &Args,
    stage: Stage,
    start: Start,
    out: PathBuf,
    minutes: Option<f64>,
    stop: &Arc<AtomicBool>,
    Watched { joined, page }: &Watched<'_>,
) -> Result<Outcome, Failure> {
    let preset = args.resolve(stage, &start, &out)?.preset;
    let threads = thread_count(args.threads)?;
    let ranks = Arc::clone(&joined.ranks);
    let job = StageJob { preset, out, start, limits: Limits { minutes }, threads, ranks };
    let first = joined.is_first();
    if let Some(page) = page {
        page.follow(&job.out);
    }
    let mut printer = Printer {
        json: args.json && first,
        quiet: args.quiet || !first,
        last: None,
        comparer: Comparer::default(),
        warned: !first,
    };
    if !printer.quiet && job.ranks.count() == 1 && !matches!(job.start, Start::Resume) {
        // A resumed run keeps its shards.
        without_work(threads, &job.preset.run).iter().for_each(|text| eprintln!("{text}"));
    }
    let mut judge = if first { judge(&job) } else { None };
    let mut report = |record: &Record| printer.iteration(record);
    let mut outcome =
        train_judged_stage(&job, stop, &mut report, judge.as_mut().map(|j| j as &mut dyn Judge))?;
    printer.end(&job, &outcome);
    if first && outcome.end != End::Stopped && contacts::matter_to(&job.preset.task) {
        if !printer.quiet {
            // Standard output may be lines of JSON.
            eprintln!("measuring contacts");
        }
        match contacts::keep_of_run(&job.out, threads, stop)? {
            Some(report) if !printer.quiet && !printer.json => println!("{}", report.summary()),
            None if stop.load(Ordering::SeqCst) => {
                let policy = job.out.join(POLICY_FILE);
                eprintln!(
                    "the contacts were not measured; measure them with `paid eval contacts --policy {} --keep`",
                    policy.display()
                );
                outcome.end = End::Stopped;
            }
            _ => {}
        }
    }
    Ok(outcome)
}

/// Scores in MuJoCo during training, if the preset asks for them. Without MuJoCo a warning is printed and training continues.
fn judge(job: &StageJob) -> Option<MujocoJudge<'static>> {
    let config = job.preset.run.judge;
    if config.every_iterations == 0 || !job.preset.task.scene.ball {
        return None;
    }
    let failed = |error: &EvalError| eprintln!("run.judge: no score: {error}");
    MujocoJudge::new(config, job.threads, failed)
        .map_err(|error| eprintln!("run.judge: no scores in the log: {error}"))
        .ok()
}
