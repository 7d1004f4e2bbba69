//! One stage from start to end: set up, iterate, log, save.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use paid_learn::ranks::gather_numbers;
use paid_learn::{Checkpoint, Ranks};
use paid_play::{POLICY_FILE, PRESET_FILE};
use paid_task::TrainShard;

use crate::folder::{self, RunFolder};
use crate::meeting::{hosts, meet};
use crate::policy_file::{LICENSE, TrainedPolicy};
use crate::policy_weights::{load_start, mean_of_run};
use crate::trainer::progress_of;
use crate::{Judge, Named, Record, RunPreset, Scene, TrainError, Trainer};

/// Where a stage starts.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Start {
    /// Fresh networks.
    Fresh,
    /// The networks and normalizer of a run folder's policy, a checkpoint or a policy file ([`load_start`]); optimizer and counters are
    /// fresh.
    From(PathBuf),
    /// The last checkpoint of the output folder, exactly.
    Resume,
}

/// What else than its preset's iterations ends a stage.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Limits {
    /// Wall clock of this start `[min]`.
    pub minutes: Option<f64>,
}

/// Iterations after which there is a checkpoint before the first regular one: who watches sees a policy within seconds.
const EARLY: [u64; 3] = [1, 10, 30];

/// Name of the checkpoint for the evaluator, which exists while it reads it.
const JUDGED_FILE: &str = "judged.safetensors";

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
    /// Worker threads of this rank; results do not depend on them.
    pub threads: usize,
    /// The processes that train together. The first one writes the run folder, which all of them can read.
    pub ranks: Arc<dyn Ranks>,
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

/// Trains a stage. `stop` is looked at between iterations; when it is set the state is saved and the function returns. The policy, a
/// mean of the last checkpoints if the preset says so, lies in the run folder then, as ONNX and as a small checkpoint.
///
/// # Errors
/// Bad input, or a file that cannot be written; files written before stay whole.
pub fn train_stage(
    job: &StageJob,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
) -> Result<Outcome, TrainError> {
    train_judged_stage(job, stop, report, None)
}

/// [`train_stage`] with an evaluator, which scores as often as the preset says ([`crate::RunConfig::judge`]).
///
/// # Errors
/// As [`train_stage`].
pub fn train_judged_stage(
    job: &StageJob,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
    judge: Option<&mut dyn Judge>,
) -> Result<Outcome, TrainError> {
    train_in(&Scene::load(&job.preset)?, job, stop, report, judge)
}

/// [`train_judged_stage`] with a scene of one's own, [`Scene::with_library`] say, instead of what the preset's files hold.
///
/// # Errors
/// As [`train_stage`].
pub fn train_in(
    scene: &Scene,
    job: &StageJob,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
    judge: Option<&mut dyn Judge>,
) -> Result<Outcome, TrainError> {
    let ranks = &job.ranks;
    let scene = &scene.clone().with_teacher(&job.preset)?;
    meet_for(job, scene)?;
    let build = |preset: &RunPreset| {
        let trainer = Trainer::new(preset, scene.shards_of(preset, &**ranks)?, scene.motion_names())?;
        let trainer = trainer.with_ranks(Arc::clone(ranks));
        scene.equip(preset, trainer)
    };
    let outcome = run_stage(job, &build, stop, report, judge)?;
    if ranks.rank() == 0 {
        write_policy(job)?;
    }
    // The next stage reads what the first rank has written.
    ranks.gather(&[]);
    Ok(outcome)
}

/// The policy's file.
fn write_policy(job: &StageJob) -> Result<(), TrainError> {
    TrainedPolicy::of(&mean_of_run(&job.out)?)?.write_onnx(&job.out.join(POLICY_FILE), LICENSE, None)
}

/// Refuses ranks that would not train the same thing: another program, instruction set, preset, start, robot, or other motions.
fn meet_for(job: &StageJob, scene: &Scene) -> Result<(), TrainError> {
    meet(&*job.ranks, |own| {
        own.tell_run(&job.preset, scene)?;
        match &job.start {
            Start::Fresh => own.tell("start", "with fresh networks"),
            Start::Resume => own.tell_file("resumed checkpoint", &folder::latest_checkpoint(&job.out)?)?,
            Start::From(file) if file.is_file() => own.tell_file("start from a policy", file)?,
            Start::From(run) => own.tell_file("start from a run", &folder::latest_checkpoint(run)?)?,
        }
        Ok(())
    })
}

/// What holds for the next iteration on every rank: the first one's clock, and anybody's wish to stop. `weights` are the sum of the policy's
/// bits, which must be everyone's.
fn agreed(
    ranks: &dyn Ranks,
    (share, is_up): (f64, bool),
    stop: bool,
    weights: u32,
) -> Result<(f64, bool, bool), TrainError> {
    let flags = [is_up, stop].map(|flag| f64::from(u8::from(flag)));
    let all = gather_numbers(ranks, &[share, flags[0], flags[1], f64::from(weights)]);
    if let Some(rank) = all.iter().position(|each| each[3] != all[0][3]) {
        let hosts = hosts(ranks);
        return Err(TrainError::Ranks(format!(
            "rank {rank} on {}: expected the weights of rank 0 on {}, found others",
            hosts[rank], hosts[0]
        )));
    }
    Ok((all[0][0], all[0][1] != 0.0, all.iter().any(|each| each[2] != 0.0)))
}

/// [`train_stage`] with trainers from `build`, a new one for each phase.
pub(crate) fn run_stage<E: TrainShard + ?Sized>(
    job: &StageJob,
    build: &dyn Fn(&RunPreset) -> Result<Trainer<E>, TrainError>,
    stop: &AtomicBool,
    report: &mut dyn FnMut(&Record),
    mut judge: Option<&mut dyn Judge>,
) -> Result<Outcome, TrainError> {
    let preset = &job.preset;
    let config = &preset.run;
    let of_phase = |begun: usize| {
        let fail = |message: String| TrainError::Preset { place: preset.stage.clone(), message };
        build(&preset.in_phase(begun).map_err(fail)?)
    };
    let text = preset.to_toml()?;
    let writes = job.ranks.rank() == 0;
    let (mut trainer, mut run, mut saved);
    match &job.start {
        Start::Resume => {
            let path = folder::latest_checkpoint(&job.out)?;
            let checkpoint = Checkpoint::load(&path)?;
            trainer = of_phase(progress_of(&checkpoint)?.phase.min(preset.phases.len()))?;
            trainer.resume(&checkpoint)?;
            run = None;
            if writes {
                folder::write(&job.out.join(PRESET_FILE), text.as_bytes())?;
                run = Some(RunFolder::resume(&job.out, trainer.progress().iteration)?);
            }
            saved = Some(path);
        }
        start => {
            trainer = of_phase(0)?;
            if let Start::From(from) = start {
                trainer.start_from(&load_start(from, preset)?)?;
            }
            run = if writes { Some(RunFolder::create(&job.out, &text)?) } else { None };
            saved = None;
        }
    }
    let first = trainer.progress().iteration;
    let clock = Clock::new(job.limits, trainer.progress().share, first, config.iterations);
    let end = loop {
        let done = trainer.progress().iteration;
        if done >= config.iterations {
            break End::Done;
        }
        let share = clock.share(done);
        let weights =
            trainer.learner().actor().params.iter().fold(0_u32, |sum, x| sum.wrapping_add(x.to_bits()));
        let (share, is_up, stopped) =
            agreed(&*job.ranks, (share, clock.is_up()), stop.load(Ordering::SeqCst), weights)?;
        if stopped {
            break End::Stopped;
        }
        if is_up {
            break End::TimeUp;
        }
        let phase = preset.phase(share);
        if phase != trainer.progress().phase {
            let state = saved.take().map_or_else(|| save(&trainer, job, run.as_ref()), Ok)?;
            trainer = of_phase(phase)?;
            trainer.next_phase(&Checkpoint::load(&state)?, phase)?;
        }
        trainer.anneal(share);
        let mut record = trainer.iterate(job.threads)?;
        record.eta_s = clock.eta_s(record.iteration - first, config.iterations - record.iteration);
        if !preset.phases.is_empty() {
            record.metrics.push("phase", phase as f64);
        }
        if let Some(run) = &mut run {
            if let Some(judge) = judge.as_deref_mut().filter(|_| config.judge.is_due(record.iteration)) {
                record.judge = judged(&trainer, run, judge)?;
            }
            run.log(&record)?;
            report(&record);
        }
        saved = None;
        let due = record.iteration.is_multiple_of(config.checkpoint_interval);
        if due || EARLY.contains(&record.iteration) {
            saved = Some(save(&trainer, job, run.as_ref())?);
        }
    };
    let checkpoint = saved.map_or_else(|| save(&trainer, job, run.as_ref()), Ok)?;
    let progress = trainer.progress();
    Ok(Outcome { end, iteration: progress.iteration, samples: progress.samples, checkpoint })
}

/// The evaluator's figures of the present policy, and the time that they took. The checkpoint that it reads is removed again.
fn judged<E: TrainShard + ?Sized>(
    trainer: &Trainer<E>,
    run: &RunFolder,
    judge: &mut dyn Judge,
) -> Result<Named, TrainError> {
    let start = Instant::now();
    let path = run.path().join(JUDGED_FILE);
    trainer.save_policy(&path)?;
    let mut figures = judge.score(&path);
    std::fs::remove_file(&path).map_err(TrainError::write(&path))?;
    figures.push("seconds", start.elapsed().as_secs_f64());
    Ok(figures)
}

/// The wall clock of a start.
struct Clock {
    start: Instant,
    limit_s: Option<f64>,
    /// The share of the run that was over before.
    before: f64,
    /// Iterations done before.
    first: u64,
    iterations: u64,
}

impl Clock {
    fn new(limits: Limits, before: f64, first: u64, iterations: u64) -> Self {
        Self { start: Instant::now(), limit_s: limits.minutes.map(|m| m * 60.0), before, first, iterations }
    }

    fn elapsed_s(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    fn is_up(&self) -> bool {
        self.limit_s.is_some_and(|limit| self.elapsed_s() >= limit)
    }

    /// The share of the run that is over after `done` iterations, by these or, if that is further, by time: a limit spreads what is left of
    /// the run over this start. Without one it is spread over the iterations that are left, so that a run which a limit has taken further
    /// than its iterations does not go back.
    fn share(&self, done: u64) -> f64 {
        let of_all = |iterations: u64| iterations as f64 / self.iterations as f64;
        let spent = match self.limit_s {
            Some(limit) => self.elapsed_s() / limit,
            // Otherwise the shares are equal but for rounding, and a resumed run has those of one that was never stopped.
            None if self.before > of_all(self.first) => {
                (done - self.first) as f64 / (self.iterations - self.first).max(1) as f64
            }
            None => 0.0,
        };
        (self.before + (1.0 - self.before) * spent).max(of_all(done)).min(1.0)
    }

    /// Time to the end after `done` iterations of this start, with `left` to go `[s]`.
    fn eta_s(&self, done: u64, left: u64) -> f64 {
        let spent = self.elapsed_s();
        let to_budget = spent / done as f64 * left as f64;
        self.limit_s.map_or(to_budget, |limit| to_budget.min((limit - spent).max(0.0)))
    }
}

/// Writes a checkpoint, which every rank has a part in, and removes old ones.
fn save<E: TrainShard + ?Sized>(
    trainer: &Trainer<E>,
    job: &StageJob,
    run: Option<&RunFolder>,
) -> Result<PathBuf, TrainError> {
    let path = job.out.join(folder::checkpoint_name(trainer.progress().iteration));
    trainer.save(&path)?;
    if let Some(run) = run {
        run.prune(job.preset.run.keep_checkpoints)?;
    }
    // The next reader finds it whole.
    job.ranks.gather(&[]);
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_timed_run_that_resumes_without_a_limit_continues_from_its_share() {
        let share = |before: f64, done: u64| Clock::new(Limits::default(), before, 1000, 7000).share(done);
        // A limit had taken it to three quarters.
        assert_eq!([1000, 4000, 7000].map(|done| share(0.75, done)), [0.75, 0.875, 1.0]);
        // One without a limit has the shares of its iterations to the last bit.
        for done in [1000, 1001, 4321, 7000] {
            assert_eq!(share(999.0 / 7000.0, done), done as f64 / 7000.0);
        }
        // It is never behind its iterations.
        assert_eq!(share(0.0, 3500), 0.5);
    }
}
