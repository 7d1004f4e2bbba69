//! `paid ablate`: the paper's ablation of its third stage. Each variant is trained from one policy and judged by MuJoCo.

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

use paid_eval::ablation::{
    Budget, Judge, JudgeSettings, SURFACES, Score, Scores, VARIANTS, has_run, is_same_run, knowledge,
    variant_preset,
};
use paid_eval::compare::Origin;
use paid_eval::file::write_whole;
use paid_eval::results::to_json;
use paid_eval::scene::Engines;
use paid_train::folder::{PRESET_FILE, forget_unsaved};
use paid_train::policy_weights::load_weights;
use paid_train::{Alone, End, Limits, RunPreset, StageJob, Start, train_stage};

use crate::eval::progress::Progress;
use crate::failure::Failure;
use crate::stage_progress::StageProgress;
use crate::stop::{self, STOPPED};
use crate::threads::thread_count;
use crate::train::motions_value;

/// Arguments of `paid ablate`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Policy (Stage I or II) that every variant starts from: a run folder (the mean of its last checkpoints) or a checkpoint.
    #[arg(long, value_name = "RUN|CHECKPOINT")]
    from: PathBuf,
    /// Folder of motion files [default: the built-in kicks].
    #[arg(long, value_name = "DIR")]
    motions: Option<PathBuf>,
    /// Output folder. A variant that was trained or judged there before is not trained or judged again.
    #[arg(long, value_name = "DIR", default_value = "runs/ablate")]
    out: PathBuf,
    /// Training iterations of every variant [default: the presets'].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    iterations: Option<u64>,
    /// Training samples of every variant, rounded up to whole iterations.
    #[arg(long, value_name = "N", conflicts_with = "iterations", value_parser = clap::value_parser!(u64).range(1..))]
    samples: Option<u64>,
    /// Change a preset value of every variant (repeatable).
    #[arg(long = "set", value_name = "KEY=VALUE")]
    sets: Vec<String>,
    #[command(flatten)]
    judging: JudgingArgs,
    /// Worker threads; they do not change the result [default: all cores].
    #[arg(long, value_name = "N")]
    threads: Option<usize>,
    /// Print the table as one line of JSON.
    #[arg(long)]
    json: bool,
    /// Print no progress, only the table.
    #[arg(long)]
    quiet: bool,
}

/// How policies are judged.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Judging")]
struct JudgingArgs {
    /// Trials at each of the three ball places of the paper's table.
    #[arg(long, default_value_t = JudgeSettings::default().trials)]
    trials: usize,
    /// Trials at each of the 63 places of the effective workspace.
    #[arg(long, default_value_t = JudgeSettings::default().workspace_trials)]
    workspace_trials: usize,
    /// Time limit of a trial [s].
    #[arg(long, default_value_t = JudgeSettings::default().limit_s)]
    limit: f64,
    /// Age of what is seen of ball and goal [s].
    #[arg(long, default_value_t = JudgeSettings::default().latency_s)]
    latency: f64,
    /// Time between two pictures [s].
    #[arg(long, default_value_t = JudgeSettings::default().frame_s)]
    frame: f64,
    /// Seed of trials and perception.
    #[arg(long, default_value_t = JudgeSettings::default().seed)]
    seed: u64,
}

impl JudgingArgs {
    fn settings(&self) -> JudgeSettings {
        JudgeSettings {
            trials: self.trials,
            workspace_trials: self.workspace_trials,
            limit_s: self.limit,
            latency_s: self.latency,
            frame_s: self.frame,
            seed: self.seed,
        }
    }
}

impl Args {
    /// Changed values of every variant's preset.
    fn overrides(&self) -> Vec<String> {
        let motions = self.motions.as_deref().map(motions_value);
        self.sets.iter().cloned().chain(motions).collect()
    }

    fn budget(&self) -> Budget {
        match (self.iterations, self.samples) {
            (Some(iterations), _) => Budget::Iterations(iterations),
            (None, Some(samples)) => Budget::Samples(samples),
            (None, None) => Budget::Preset,
        }
    }
}

/// Trains and judges every variant, or takes up what an earlier call left.
pub fn run(args: &Args) -> Result<ExitCode, Failure> {
    let settings = args.judging.settings();
    settings.check()?;
    let threads = thread_count(args.threads)?;
    Engines::Mujoco.check()?;
    let stop = stop::flag()?;
    let (overrides, budget) = (args.overrides(), args.budget());
    let mut presets = Vec::new();
    for (_, name) in VARIANTS {
        presets.push(variant_preset(name, &overrides, budget)?);
    }
    // A wrong policy is told before anything is written. All variants have the clips of this call.
    load_weights(&args.from)?;
    let origin = Origin::of(Some(&args.from), Path::new(&presets[0].run.motions))?;
    for ((_, name), preset) in VARIANTS.into_iter().zip(&presets) {
        refuse_another(&origin, &args.out.join(name), preset)?;
    }
    // All variants are judged alike: seen as the complete one is trained to see, and late.
    let judged = presets[0].clone();
    let knowledge = knowledge(&judged, &settings);
    let mut scores = Scores { settings: settings.clone(), knowledge, scores: Vec::new() };
    for ((variant, name), preset) in VARIANTS.into_iter().zip(presets) {
        let folder = args.out.join(name);
        origin.keep(&folder)?;
        forget_unsaved(&folder)?;
        let start = if has_run(&folder) { Start::Resume } else { Start::From(args.from.clone()) };
        let job = StageJob {
            preset,
            out: folder.clone(),
            start,
            limits: Limits::default(),
            threads,
            ranks: Arc::new(Alone),
        };
        let mut progress = StageProgress::new(variant.to_owned(), args.quiet);
        let outcome =
            train_stage(&job, &stop, &mut |record| progress.tell(record)).map_err(Failure::input)?;
        if outcome.end == End::Stopped {
            return Ok(ExitCode::from(STOPPED));
        }
        let judge = Judge::new(&outcome.checkpoint, &judged, &settings, threads)?;
        for surface in SURFACES {
            let file = folder.join(format!("{surface}.json"));
            let known = Score::read(&file)?.filter(|score| score.is_of(&settings, outcome.samples));
            let score = match known {
                Some(score) => score,
                None => {
                    let (monitor, progress) = Progress::start(args.quiet)?;
                    let score = judge.score(variant, surface, outcome.samples, &monitor);
                    progress.finish();
                    let Some(score) = score? else { return Ok(ExitCode::from(STOPPED)) };
                    let text = serde_json::to_string_pretty(&score).map_err(Failure::input)?;
                    write_whole(&file, text.as_bytes())?;
                    score
                }
            };
            if !args.quiet {
                eprintln!("{variant}, {surface}: {}", score.workspace.text());
            }
            scores.scores.push(score);
        }
    }
    finish(args, &scores)?;
    Ok(ExitCode::SUCCESS)
}

/// Refuses a run in `folder` that is not this call's: of another preset, or begun with another policy or other clips.
fn refuse_another(origin: &Origin, folder: &Path, preset: &RunPreset) -> Result<(), Failure> {
    if !has_run(folder) {
        return Ok(());
    }
    if !is_same_run(folder, preset)? {
        return Err(Failure::input(format!(
            "{}: expected a run with the preset and the --set values of this call, found another; choose another --out",
            folder.join(PRESET_FILE).display()
        )));
    }
    Ok(origin.refuse_another(folder)?)
}

fn finish(args: &Args, scores: &Scores) -> Result<(), Failure> {
    let table = scores.table();
    let json = to_json(scores)?;
    write_whole(&args.out.join("ablation.txt"), table.as_bytes())?;
    write_whole(&args.out.join("ablation.json"), json.as_bytes())?;
    if args.json {
        println!("{json}");
    } else {
        print!("{table}");
    }
    Ok(())
}
