//! Many trials, each an episode with a forced start, in batches over lanes and threads.
//!
//! A trial's outcome depends on the seed and its own number only: not on the number of threads and not on which trials run
//! beside it.

use std::ops::Range;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use paid_lanes::Isa;
use paid_play::ReferenceLibrary;
use paid_policy::StepBuffers;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    Disturbance, EnvSample, EpisodeRules, EvalControl, InitialState, NextKick, TaskPreset, TaskShard,
};
use paid_train::Ranks;

use crate::EvalError;
use crate::engine::EngineChoice;
use crate::monitor::Monitor;
use crate::policy::{Driver, DriverInput, DriverMaker};

/// Trials that one worker steps together: wide enough for the policy's matrix products, narrow enough to share the work.
const BATCH: usize = 64;

/// The task that the trials run in.
#[derive(Clone, Debug)]
pub struct EvalSetup {
    /// Who simulates.
    pub engine: EngineChoice,
    /// Lane type of the built-in engine.
    pub isa: Isa,
    /// The robot; with the joint control of the policy, if that brings its own ([`crate::policy::Gains::apply`]).
    pub robot: RobotModel,
    /// Its names and numbers.
    pub spec: RobotSpec,
    /// The motions.
    pub library: Arc<ReferenceLibrary>,
    /// The task.
    pub preset: TaskPreset,
    /// Worker threads; at least one is used.
    pub threads: usize,
    /// Seed of everything random.
    pub seed: u64,
    /// Progress, effort and a way to stop.
    pub monitor: Monitor,
    /// The processes that share out the trials of [`crate::share::run_shared`].
    pub ranks: Arc<dyn Ranks>,
}

/// How the task says that an episode ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// By a failure.
    Failed,
    /// By the motion's end or the time limit.
    Over,
}

/// Watches one trial.
pub trait Observer: Send {
    /// Sees the state at the start and after every control step; `ended` is set when the task ended the episode at this
    /// state. Returns true when it has seen enough.
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool;

    /// Sees of environment `env` of `world` what a sample does not hold, before [`Observer::observe`] sees the sample.
    ///
    /// # Errors
    /// If the environment does not exist.
    fn look_on(&mut self, _world: &dyn EvalControl, _env: usize) -> Result<(), EvalError> {
        Ok(())
    }

    /// What the robot is to kick next, from its present pose; called after every [`Observer::observe`] that continues. `None`: it continues
    /// with what it does.
    fn next_kick(&mut self) -> Option<NextKick> {
        None
    }

    /// What disturbs the robot before the next control step; called after every [`Observer::observe`] that continues.
    fn disturbance(&mut self) -> Option<Disturbance> {
        None
    }
}

/// Sees nothing.
impl Observer for () {
    fn observe(&mut self, _sample: &EnvSample, _ended: Option<Ending>) -> bool {
        false
    }
}

/// Two observers of one trial. The first says when it has seen enough, and what is to be kicked next; the second disturbs.
pub(crate) struct Beside<A, B>(pub A, pub B);

impl<A: Observer, B: Observer> Observer for Beside<A, B> {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        self.1.observe(sample, ended);
        self.0.observe(sample, ended)
    }
    fn look_on(&mut self, world: &dyn EvalControl, env: usize) -> Result<(), EvalError> {
        self.0.look_on(world, env)?;
        self.1.look_on(world, env)
    }
    fn next_kick(&mut self) -> Option<NextKick> {
        self.0.next_kick()
    }
    fn disturbance(&mut self) -> Option<Disturbance> {
        self.1.disturbance()
    }
}

/// Runs every start as a trial and returns the observers of those that ended, with their numbers, in the order of
/// `starts`: all of them, unless the setup's monitor was stopped. `observer` makes the observer of a trial by number.
/// A trial is over when its observer says so, when the task ended its episode, or after `max_steps` control steps.
///
/// # Errors
/// If the policy does not fit the task or returns a number that is not finite, the task refuses a start, or the engine cannot
/// be built.
pub fn run_episodes<O: Observer>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    starts: &[InitialState],
    rules: EpisodeRules,
    max_steps: usize,
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(usize, O)>, EvalError> {
    run_batches(setup, policy, starts, rules, max_steps, |_| true, observer)
}

/// As [`run_episodes`], for the batches with the numbers `wanted` alone.
pub(crate) fn run_batches<O: Observer>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    starts: &[InitialState],
    rules: EpisodeRules,
    max_steps: usize,
    wanted: impl Fn(usize) -> bool,
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(usize, O)>, EvalError> {
    let run = Run { setup, policy, starts, rules, max_steps, observer: &observer };
    let width = run.width();
    let batches = (0..starts.len()).step_by(width).map(|first| first..(first + width).min(starts.len()));
    let wanted = batches.enumerate().filter(|(number, _)| wanted(*number)).map(|(_, batch)| batch);
    run.batches(&wanted.collect::<Vec<_>>())
}

/// As [`run_episodes`], for the trials with the numbers `wanted` alone: each goes as it went among all of `starts`.
///
/// # Errors
/// As [`run_episodes`].
///
/// # Panics
/// If there is no such trial.
pub fn run_again<O: Observer>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    starts: &[InitialState],
    rules: EpisodeRules,
    max_steps: usize,
    wanted: &[usize],
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(usize, O)>, EvalError> {
    let run = Run { setup, policy, starts, rules, max_steps, observer: &observer };
    run.batches(&wanted.iter().map(|&trial| trial..trial + 1).collect::<Vec<_>>())
}

/// What all batches of a run share.
struct Run<'a, F> {
    setup: &'a EvalSetup,
    policy: &'a DriverMaker<'a>,
    starts: &'a [InitialState],
    rules: EpisodeRules,
    max_steps: usize,
    observer: &'a F,
}

impl<O: Observer, F: Fn(usize) -> O + Sync> Run<'_, F> {
    /// Trials of a batch. On the built-in engine as many as make the policy's products worth while; an engine without
    /// lanes gets one at a time, so that no finished trial is simulated along with longer ones.
    fn width(&self) -> usize {
        if self.setup.lanes() == 1 { 1 } else { BATCH }
    }

    /// Runs batches of trials, each a worker's.
    fn batches(&self, batches: &[Range<usize>]) -> Result<Vec<(usize, O)>, EvalError> {
        let setup = self.setup;
        let trials = batches.iter().map(Range::len).sum();
        let next = AtomicUsize::new(0);
        let results = Mutex::new(Vec::new());
        setup.monitor.plan(trials);
        let worker = || {
            while !setup.monitor.stopped() {
                let batch = next.fetch_add(1, Ordering::Relaxed);
                let Some(trials) = batches.get(batch) else { break };
                let result = self.batch(trials.clone());
                let failed = result.is_err();
                results.lock().unwrap_or_else(PoisonError::into_inner).push((batch, result));
                if failed {
                    // The others need not continue for an evaluation that fails.
                    next.store(batches.len(), Ordering::Relaxed);
                }
            }
        };
        thread::scope(|scope| {
            for _ in 1..setup.threads.clamp(1, batches.len().max(1)) {
                scope.spawn(worker);
            }
            worker();
        });
        let mut results = results.into_inner().unwrap_or_else(PoisonError::into_inner);
        results.sort_by_key(|(batch, _)| *batch);
        let mut all = Vec::with_capacity(trials);
        for (_, result) in results {
            all.extend(result?);
        }
        Ok(all)
    }

    /// Runs the trials of a batch.
    fn batch(&self, trials: Range<usize>) -> Result<Vec<(usize, O)>, EvalError> {
        let Self { setup, starts, .. } = *self;
        let envs = trials.len().next_multiple_of(setup.lanes());
        let mut shard = setup.build(envs, trials.start)?;
        let mut policy = (self.policy)()?;
        check_contract(shard.as_ref(), policy.as_ref())?;
        let mut observers: Vec<O> = trials.clone().map(self.observer).collect();

        let control = shard.eval();
        control.set_rules(self.rules);
        for env in 0..envs {
            // Environments beyond the last trial fill the lane group with copies of it.
            control.force_start(env, &starts[(trials.start + env).min(trials.end - 1)])?;
        }
        policy.begin(envs);
        let mut active = vec![true; observers.len()];
        look(control, policy.as_mut(), &mut observers, &mut active, [&[], &[]])?;

        let mut observations = vec![0.0; shard.policy_obs_dim() * envs];
        let mut critic = vec![0.0; shard.critic_obs_dim() * envs];
        let mut actions = vec![0.0; shard.action_dim() * envs];
        let mut reward = vec![0.0; envs];
        let (mut terminated, mut truncated) = (vec![0; envs], vec![0; envs]);
        for step in 0..self.max_steps {
            if !active.contains(&true) || setup.monitor.stopped() {
                break;
            }
            let start = Instant::now();
            shard.observe(&mut [&mut observations, &mut critic]);
            let observed = Instant::now();
            policy
                .act(DriverInput { observations: &observations, envs, world: shard.eval() }, &mut actions)?;
            let acted = Instant::now();
            if let Some(i) = actions.iter().position(|a| !a.is_finite()) {
                let trial = (trials.start + i % envs).min(trials.end - 1);
                return Err(EvalError::Action { action: i / envs, trial, step, value: actions[i] });
            }
            shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
            let physics = acted.elapsed() + (observed - start);
            setup.monitor.spend(envs, physics, acted - observed);
            let before = active.iter().filter(|a| **a).count();
            let ended = [&terminated[..], &truncated];
            look(shard.eval(), policy.as_mut(), &mut observers, &mut active, ended)?;
            setup.monitor.finish(before - active.iter().filter(|a| **a).count());
        }
        let stopped = setup.monitor.stopped();
        if !stopped {
            setup.monitor.finish(active.iter().filter(|a| **a).count());
        }
        let ended = trials.zip(observers).zip(active).filter(|(_, active)| !(stopped && *active));
        Ok(ended.map(|(result, _)| result).collect())
    }
}

fn look<O: Observer>(
    control: &mut dyn EvalControl,
    policy: &mut dyn Driver,
    observers: &mut [O],
    active: &mut [bool],
    [terminated, truncated]: [&[u8]; 2],
) -> Result<(), EvalError> {
    let set = |flags: &[u8], env: usize| flags.get(env).is_some_and(|f| *f != 0);
    for (env, observer) in observers.iter_mut().enumerate() {
        if !active[env] {
            continue;
        }
        let ended = if set(terminated, env) {
            Some(Ending::Failed)
        } else {
            set(truncated, env).then_some(Ending::Over)
        };
        observer.look_on(control, env)?;
        let enough = observer.observe(&control.sample(env)?, ended);
        active[env] = !enough && ended.is_none();
        if active[env]
            && let Some(next) = observer.next_kick()
        {
            control.next_kick(env, &next)?;
            policy.forget(env);
        }
        if active[env]
            && let Some(disturbance) = observer.disturbance()
        {
            control.disturb(env, &disturbance)?;
        }
    }
    Ok(())
}

fn check_contract(shard: &dyn TaskShard, policy: &dyn Driver) -> Result<(), EvalError> {
    let pairs = [
        (
            "length of the observation",
            shard.policy_obs_dim(),
            policy.obs_dim().unwrap_or_else(|| shard.policy_obs_dim()),
        ),
        ("length of the action", shard.action_dim(), policy.action_dim()),
    ];
    match pairs.into_iter().find(|(_, task, policy)| task != policy) {
        Some((what, task, policy)) => Err(EvalError::Contract { what, task, policy }),
        None => Ok(()),
    }
}
