//! Training speed: the whole, and its parts measured alone in the same run.

use std::fs;
use std::time::Instant;

use paid_lanes::rng::Rng;
use paid_learn::parallel::for_each;
use paid_learn::{Learner, StepBuffers, VecEnv};
use serde::Serialize;

use crate::shard::Handle;
use crate::{RunPreset, Scene, TrainError, TrainShard, Trainer};

/// What a benchmark of training found. Rates are samples (control steps times environments) a second.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrainBench {
    /// What was run.
    pub name: String,
    /// Environments.
    pub envs: usize,
    /// Shards.
    pub shards: usize,
    /// Worker threads.
    pub threads: usize,
    /// Instruction set of the physics.
    pub isa: String,
    /// Iterations that were measured.
    pub iterations: u64,
    /// Rollout and update together, as in training.
    pub samples_per_s: f64,
    /// Physics and task alone, under random actions.
    pub env_samples_per_s: f64,
    /// Normalization, both networks and sampling alone, on stored observations.
    pub forward_samples_per_s: f64,
    /// Update alone.
    pub update_samples_per_s: f64,
    /// What the three parts would add up to.
    pub parts_samples_per_s: f64,
    /// The whole over what the parts would add up to.
    pub ratio: f64,
    /// Largest memory of the process while training [MiB]; 0 where the system does not tell.
    pub peak_rss_mib: f64,
}

/// An environment that costs nothing: it shows one stored observation for ever.
struct Still {
    dims: [usize; 3],
    envs: usize,
    policy: Vec<f32>,
    critic: Vec<f32>,
}

impl VecEnv for Still {
    fn num_envs(&self) -> usize {
        self.envs
    }
    fn policy_obs_dim(&self) -> usize {
        self.dims[0]
    }
    fn critic_obs_dim(&self) -> usize {
        self.dims[1]
    }
    fn action_dim(&self) -> usize {
        self.dims[2]
    }
    fn observe(&mut self, policy: &mut [f32], critic: &mut [f32]) {
        policy.copy_from_slice(&self.policy);
        critic.copy_from_slice(&self.critic);
    }
    fn step(&mut self, _actions: &[f32], out: StepBuffers<'_>) {
        out.reward.fill(0.0);
        out.terminated.fill(0);
        out.truncated.fill(0);
    }
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }
    fn restore(&mut self, _bytes: &[u8]) -> Result<(), String> {
        Ok(())
    }
}

/// Random actions and buffers of a shard.
struct Driver<E> {
    shard: Handle<E>,
    rng: Rng,
    action: Vec<f32>,
    policy: Vec<f32>,
    critic: Vec<f32>,
    reward: Vec<f32>,
    ends: [Vec<u8>; 2],
}

impl<E: TrainShard> Driver<E> {
    fn new(shard: Handle<E>, number: u32) -> Self {
        let n = shard.num_envs();
        Self {
            rng: Rng::new(0, number, 0),
            action: vec![0.0; n * shard.action_dim()],
            policy: vec![0.0; n * shard.policy_obs_dim()],
            critic: vec![0.0; n * shard.critic_obs_dim()],
            reward: vec![0.0; n],
            ends: [vec![0; n], vec![0; n]],
            shard,
        }
    }

    /// A horizon under uniform actions of standard deviation 0.4, the usual one of a policy in training.
    fn roll(&mut self, horizon: usize) {
        for _ in 0..horizon {
            self.rng.fill_unit(&mut self.action);
            for a in &mut self.action {
                *a = (*a - 0.5) * 1.4;
            }
            self.shard.observe(&mut self.policy, &mut self.critic);
            let [terminated, truncated] = &mut self.ends;
            self.shard.step(&self.action, StepBuffers { reward: &mut self.reward, terminated, truncated });
        }
    }
}

/// Trains for about `seconds` (three quarters of it in the parts) and measures.
///
/// # Errors
/// If the preset's robot, motions or task cannot be built.
pub fn bench_train(
    name: &str,
    preset: &RunPreset,
    threads: usize,
    seconds: f64,
) -> Result<TrainBench, TrainError> {
    let scene = Scene::load(preset)?;
    let mut trainer = Trainer::new(preset, scene.shards(preset)?, scene.motion_names())?;
    // The first iterations allocate; the memory of training is what they reach.
    for _ in 0..2 {
        trainer.iterate(threads)?;
    }
    let peak_rss_mib = peak_rss_mib();
    let mut drivers: Vec<_> =
        trainer.handles().enumerate().map(|(i, shard)| Driver::new(shard, i as u32)).collect();
    let horizon = preset.learn.ppo.horizon;
    let mut workers = vec![(); threads];
    let setup = |error: &dyn core::fmt::Display| TrainError::Setup(error.to_string());
    for_each(&mut workers, drivers.iter_mut().collect(), |(), driver| driver.roll(1));
    let mut stills: Vec<Box<dyn VecEnv>> = Vec::new();
    for driver in &drivers {
        let shard = &driver.shard;
        stills.push(Box::new(Still {
            dims: [shard.policy_obs_dim(), shard.critic_obs_dim(), shard.action_dim()],
            envs: shard.num_envs(),
            policy: driver.policy.clone(),
            critic: driver.critic.clone(),
        }));
    }
    let mut forward: Learner = trainer.learner().clone();
    forward.collect(&mut stills, threads).map_err(|e| setup(&e))?;
    let mut times = [0.0; 4];
    let mut iterations = 0;
    let begin = Instant::now();
    while iterations == 0 || begin.elapsed().as_secs_f64() < seconds {
        let mut lap = Instant::now();
        let mut take = |slot: &mut f64| {
            *slot += lap.elapsed().as_secs_f64();
            lap = Instant::now();
        };
        trainer.iterate(threads)?;
        take(&mut times[0]);
        for_each(&mut workers, drivers.iter_mut().collect(), |(), driver| driver.roll(horizon));
        take(&mut times[1]);
        forward.collect(&mut stills, threads).map_err(|e| setup(&e))?;
        take(&mut times[2]);
        forward.update(threads);
        take(&mut times[3]);
        iterations += 1;
    }
    let samples = iterations as f64 * (preset.run.envs * horizon) as f64;
    let [whole, env, forward, update] = times.map(|time| samples / time);
    let parts = samples / (times[1] + times[2] + times[3]);
    Ok(TrainBench {
        name: name.to_owned(),
        envs: preset.run.envs,
        shards: preset.run.shards,
        threads,
        isa: preset.isa().map_err(TrainError::Setup)?.to_string(),
        iterations,
        samples_per_s: whole,
        env_samples_per_s: env,
        forward_samples_per_s: forward,
        update_samples_per_s: update,
        parts_samples_per_s: parts,
        ratio: whole / parts,
        peak_rss_mib,
    })
}

/// Largest resident memory of this process so far [MiB] (`VmHWM` of Linux's `/proc/self/status`).
pub fn peak_rss_mib() -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix("kB")?.trim().parse::<f64>().ok())
        .map_or(0.0, |kib| kib / 1024.0)
}
