//! One stage from start to end: set up, iterate, log, save.

use std::fs;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use paid_learn::checkpoint::write_atomically;

use crate::folder::{self, PRESET_FILE, RunFolder};
use crate::policy_file::{LICENCE, POLICY_FILE, TrainedPolicy};
use crate::{Record, RunPreset, Scene, TrainError, TrainShard, Trainer};

/// Where a stage starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// Fresh networks.
    Fresh,
    /// The networks and normaliser of a run folder or checkpoint; optimiser and counters are fresh.
    From(PathBuf),
    /// The last checkpoint of the output folder, exactly.
    Resume,
}

/// What ends a stage besides its preset's iterations.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Wall clock of this start [min].
    pub minutes: Option<f64>,
}

/// A stage to be trained.
#[derive(Clone, Debug)]
pub struct StageJob {
    /// Everything about it.
    pub preset: RunPreset,
    /// The run folder.
    pub out: PathBuf,
    /// Where it starts.
    pub start: Start,
    /// What else ends it.
    pub limits: Limits,
    /// Worker threads; results do not depend on them.
    pub threads: usize,
}

/// Why a stage ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// All iterations are done.
    Done,
    /// The time limit.
    TimeUp,
    /// The stop flag.
    Stopped,
}

/// How a stage ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Why.
    pub end: End,
    /// Iterations done.
    pub iteration: u64,
    /// Environment steps done.
    pub samples: u64,
    /// The last checkpoint.
    pub checkpoint: PathBuf,
}

/// Trains a stage. `stop` is looked at between iterations; when it is set the state is saved and the function returns.
///
/// # Errors
/// Bad input, or a file that cannot be written; files written before stay whole.
pub fn train_stage(
    job: &StageJob,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
) -> Result<Outcome, TrainError> {
    let preset = &job.preset;
    let scene = Scene::load(preset)?;
    let mut trainer = Trainer::new(preset, scene.shards(preset)?, scene.motion_names())?;
    let text = preset.to_toml()?;
    let mut run = match &job.start {
        Start::Fresh => RunFolder::create(&job.out, &text)?,
        Start::From(from) => {
            trainer.start_from(&folder::latest_checkpoint(from)?)?;
            RunFolder::create(&job.out, &text)?
        }
        Start::Resume => {
            trainer.resume(&folder::latest_checkpoint(&job.out)?)?;
            write_atomically(&job.out.join(PRESET_FILE), text.as_bytes())?;
            RunFolder::resume(&job.out, trainer.progress().iteration)?
        }
    };
    let outcome = run_iterations(job, &mut trainer, &mut run, stop, report)?;
    TrainedPolicy::load(&outcome.checkpoint)?.write_onnx(&job.out.join(POLICY_FILE), LICENCE, None)?;
    Ok(outcome)
}

/// The loop of [`train_stage`].
pub(crate) fn run_iterations<E: TrainShard + 'static>(
    job: &StageJob,
    trainer: &mut Trainer<E>,
    run: &mut RunFolder,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
) -> Result<Outcome, TrainError> {
    let config = &job.preset.run;
    let start = Instant::now();
    let first = trainer.progress().iteration;
    let limit_s = job.limits.minutes.map(|m| m * 60.0);
    let mut saved = None;
    let end = loop {
        let done = trainer.progress().iteration;
        if done >= config.iterations {
            break End::Done;
        }
        if stop.load(Ordering::SeqCst) {
            break End::Stopped;
        }
        let time_share = limit_s.map_or(0.0, |limit| start.elapsed().as_secs_f64() / limit);
        if time_share >= 1.0 {
            break End::TimeUp;
        }
        trainer.anneal(time_share.max(done as f64 / config.iterations as f64));
        let mut record = trainer.iterate(job.threads)?;
        let spent = start.elapsed().as_secs_f64();
        let per_iteration = spent / (record.iteration - first) as f64;
        let to_budget = per_iteration * (config.iterations - record.iteration) as f64;
        record.eta_s = limit_s.map_or(to_budget, |limit| to_budget.min((limit - spent).max(0.0)));
        run.log(&record)?;
        report(&record);
        if record.iteration.is_multiple_of(config.checkpoint_interval) {
            saved = Some(save(trainer, run, config.keep_checkpoints)?);
        }
    };
    let progress = trainer.progress();
    let (iteration, samples) = (progress.iteration, progress.samples);
    let current = run.path().join(folder::checkpoint_name(iteration));
    let checkpoint = match saved {
        Some(path) if path == current => path,
        _ if current.exists() && iteration == first => current,
        _ => save(trainer, run, config.keep_checkpoints)?,
    };
    Ok(Outcome { end, iteration, samples, checkpoint })
}

fn save<E: TrainShard + 'static>(
    trainer: &Trainer<E>,
    run: &RunFolder,
    keep: usize,
) -> Result<PathBuf, TrainError> {
    let path = run.path().join(folder::checkpoint_name(trainer.progress().iteration));
    trainer.save(&path)?;
    run.prune(keep)?;
    Ok(path)
}

impl RunPreset {
    /// The resolved preset that a run saved, with overrides.
    ///
    /// # Errors
    /// If the folder holds none, or an override does not apply.
    pub fn of_run(run: &std::path::Path, overrides: &[String]) -> Result<Self, TrainError> {
        let path = run.join(PRESET_FILE);
        let text = fs::read_to_string(&path).map_err(TrainError::read(&path))?;
        Self::from_resolved(&path.to_string_lossy(), &text, overrides)
    }
}
