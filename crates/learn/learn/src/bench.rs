//! Speed of the learner alone, on an environment that costs next to nothing.

use std::time::Instant;

use paid_lanes::rng::Rng;

use crate::config::{ConfigError, LearnConfig};
use crate::learner::Learner;
use crate::net::TrainNetwork;
use crate::parallel::for_each;
use paid_policy::matrix::{Mat, MatMut, multiply};
use paid_policy::{ObservationGroup, StepBuffers, VecEnv};

/// Sizes of a benchmark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BenchSize {
    /// Features of the policy's observation.
    pub policy_obs: usize,
    /// Features of the critic's observation.
    pub critic_obs: usize,
    /// Number of actions.
    pub actions: usize,
    /// Shards.
    pub shards: usize,
    /// Environments per shard.
    pub envs: usize,
    /// Threads.
    pub threads: usize,
}

/// What was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize)]
pub struct LearnBench {
    /// Samples through forward, backward and Adam of both networks `[1/s]`: one epoch, all threads.
    pub update_samples_per_s: f64,
    /// Samples through normalization, both networks' forward passes and sampling `[1/s]`, all threads.
    pub collect_samples_per_s: f64,
    /// Arithmetic of the update's matrix products `[GFLOP/s]`, all threads.
    pub update_gflop_per_s: f64,
    /// Arithmetic of the `gemm` crate alone on a square product `[GFLOP/s]`, all threads.
    pub peak_gflop_per_s: f64,
}

/// Random observations, zero physics.
struct Still {
    policy: Vec<f32>,
    critic: Vec<f32>,
    actions: usize,
    envs: usize,
}

impl Still {
    fn new(size: BenchSize) -> Self {
        let mut rng = Rng::new(0, 0, 0);
        let mut normals = |n: usize| -> Vec<f32> { (0..n).map(|_| rng.normal() as f32).collect() };
        Self {
            policy: normals(size.policy_obs * size.envs),
            critic: normals(size.critic_obs * size.envs),
            actions: size.actions,
            envs: size.envs,
        }
    }
}

impl VecEnv for Still {
    fn num_envs(&self) -> usize {
        self.envs
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        ObservationGroup::policy_and_critic(self.policy.len() / self.envs, self.critic.len() / self.envs)
    }
    fn action_dim(&self) -> usize {
        self.actions
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        for (group, values) in groups.iter_mut().zip([&self.policy, &self.critic]) {
            group.copy_from_slice(values);
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        for e in 0..self.envs {
            out.reward[e] = -actions[e] * actions[e];
            out.terminated[e] = 0;
            out.truncated[e] = 0;
        }
    }
    fn save(&self) -> Vec<u8> {
        Vec::new()
    }
    fn restore(&mut self, _bytes: &[u8]) -> Result<(), String> {
        Ok(())
    }
}

/// Samples a second of the update, see [`bench()`].
///
/// # Errors
/// If the configuration is out of range.
pub fn bench_update(config: &LearnConfig, size: BenchSize, seconds: f64) -> Result<f64, ConfigError> {
    Ok(bench(config, size, seconds)?.update_samples_per_s)
}

/// Measures collection and update for about `seconds` each, after one iteration to warm up.
///
/// # Errors
/// If the configuration is out of range.
pub fn bench(config: &LearnConfig, size: BenchSize, seconds: f64) -> Result<LearnBench, ConfigError> {
    let BenchSize { policy_obs, critic_obs, actions, .. } = size;
    let mut learner = Learner::new(policy_obs, critic_obs, actions, config, 0)?;
    let mut envs: Vec<_> = (0..size.shards).map(|_| Box::new(Still::new(size))).collect();
    let mut collect = |learner: &mut Learner| {
        learner.collect(&mut envs, size.threads).map_or(0.0, |stats| stats.samples as f64)
    };
    collect(&mut learner);
    learner.update(size.threads);
    let collect_samples_per_s = rate(seconds, || collect(&mut learner));
    let samples = (size.shards * size.envs * config.ppo.horizon * config.ppo.epochs) as f64;
    let update_samples_per_s = rate(seconds, || {
        learner.update(size.threads);
        samples
    });
    let flop = learner.actor().net.train_flop() + learner.critic().net.train_flop();
    Ok(LearnBench {
        update_samples_per_s,
        collect_samples_per_s,
        update_gflop_per_s: update_samples_per_s * flop * 1e-9,
        peak_gflop_per_s: gemm_gflop_per_s(size.threads, seconds / 4.0),
    })
}

/// Calls `work`, which returns how many samples it did, for about `seconds`; samples a second.
fn rate(seconds: f64, mut work: impl FnMut() -> f64) -> f64 {
    let start = Instant::now();
    let mut samples = 0.0;
    loop {
        samples += work();
        let elapsed = start.elapsed().as_secs_f64();
        if elapsed >= seconds {
            return samples / elapsed;
        }
    }
}

/// Arithmetic rate of products of 384 x 384 matrices, one stream per thread `[GFLOP/s]`.
fn gemm_gflop_per_s(threads: usize, seconds: f64) -> f64 {
    const N: usize = 384;
    let mut workers = vec![(vec![0.5f32; N * N], vec![0.5f32; N * N], vec![0.0f32; N * N]); threads.max(1)];
    rate(seconds, || {
        let items = vec![(); 4 * threads.max(1)];
        for_each(&mut workers, items, |(a, b, c), ()| {
            multiply(MatMut::new(c, N, N, N), Mat::new(a, N, N, N), Mat::new(b, N, N, N), false);
        });
        (4 * threads.max(1) * 2 * N * N * N) as f64 * 1e-9
    })
}
