//! Training speed: the whole, and its parts measured alone in the same run.

use std::time::Instant;

use paid_lanes::rng::Rng;
use paid_learn::parallel::for_each;
use paid_learn::{Learner, Precision};
use paid_policy::{ObservationGroup, StepBuffers, VecEnv};
use paid_task::TaskShard;
use serde::Serialize;

use crate::memory::peak_rss_mib;
use crate::{RunPreset, Scene, TrainError, Trainer};

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
    /// What computes the products of hidden layers, see [`Learner::products`].
    pub products: String,
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
    /// The same training in f32, in turns with the one above; nothing where that is in f32 itself.
    pub f32: Option<F32Bench>,
    /// Largest memory of the process while training `[MiB]`; 0 where the system does not report it.
    pub peak_rss_mib: f64,
}

/// Rates of a training in f32 `[samples/s]`, and how many times faster the other is.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct F32Bench {
    /// Rollout and update together.
    pub samples_per_s: f64,
    /// Update alone.
    pub update_samples_per_s: f64,
    /// Gain of the whole.
    pub gain: f64,
    /// Gain of the update.
    pub update_gain: f64,
}

/// A training in one precision.
#[expect(clippy::vec_box, reason = "the learner takes boxed environments")]
struct Side {
    trainer: Trainer,
    /// A learner of the same kind whose environments cost nothing.
    alone: Learner,
    stills: Vec<Box<Still>>,
    /// Time in whole iterations, in the rollout's networks, in the update `[s]`.
    times: [f64; 3],
}

impl Side {
    fn new(preset: &RunPreset, scene: &Scene, threads: usize) -> Result<Self, TrainError> {
        let trainer = Trainer::new(preset, scene.shards(preset)?, scene.motion_names())?;
        let mut trainer = scene.equip(preset, trainer)?;
        // The first iterations allocate; the memory of training is what they reach.
        for _ in 0..2 {
            trainer.iterate(threads)?;
        }
        let mut stills = Vec::new();
        for (k, shard) in trainer.shards_mut().iter_mut().enumerate() {
            let mut driver = Driver::new(&**shard, k as u32);
            driver.roll(&mut **shard, 1);
            stills.push(Box::new(Still {
                groups: shard.observation_groups(),
                actions: shard.action_dim(),
                envs: shard.num_envs(),
                values: driver.values,
            }));
        }
        let alone = trainer.learner().clone();
        let mut side = Self { trainer, alone, stills, times: [0.0; 3] };
        side.forward(threads)?;
        Ok(side)
    }

    fn forward(&mut self, threads: usize) -> Result<(), TrainError> {
        let collected = self.alone.collect(&mut self.stills, threads);
        collected.map_err(|error| TrainError::Setup(error.to_string())).map(|_| ())
    }

    /// One iteration of the training, then each part of the learner alone.
    fn iterate(&mut self, threads: usize) -> Result<(), TrainError> {
        let mut lap = Instant::now();
        let mut take = |slot: &mut f64| {
            *slot += lap.elapsed().as_secs_f64();
            lap = Instant::now();
        };
        self.trainer.iterate(threads)?;
        let mut times = self.times;
        take(&mut times[0]);
        self.forward(threads)?;
        take(&mut times[1]);
        self.alone.update(threads);
        take(&mut times[2]);
        self.times = times;
        Ok(())
    }
}

/// An environment that costs nothing: it always shows one stored observation.
struct Still {
    groups: Vec<ObservationGroup>,
    actions: usize,
    envs: usize,
    values: Vec<Vec<f32>>,
}

impl VecEnv for Still {
    fn num_envs(&self) -> usize {
        self.envs
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        self.groups.clone()
    }
    fn action_dim(&self) -> usize {
        self.actions
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        for (group, values) in groups.iter_mut().zip(&self.values) {
            group.copy_from_slice(values);
        }
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

/// Random actions for a shard, and buffers.
struct Driver {
    rng: Rng,
    action: Vec<f32>,
    values: Vec<Vec<f32>>,
    reward: Vec<f32>,
    ends: [Vec<u8>; 2],
}

impl Driver {
    fn new(shard: &dyn TaskShard, number: u32) -> Self {
        let n = shard.num_envs();
        Self {
            rng: Rng::new(0, number, 0),
            action: vec![0.0; n * shard.action_dim()],
            values: shard.observation_groups().iter().map(|group| vec![0.0; n * group.size]).collect(),
            reward: vec![0.0; n],
            ends: [vec![0; n], vec![0; n]],
        }
    }

    /// A horizon under uniform actions of standard deviation 0.4, the usual one of a policy in training.
    fn roll(&mut self, shard: &mut dyn TaskShard, horizon: usize) {
        for _ in 0..horizon {
            self.rng.fill_unit(&mut self.action);
            for a in &mut self.action {
                *a = (*a - 0.5) * 1.4;
            }
            let mut groups: Vec<&mut [f32]> = self.values.iter_mut().map(Vec::as_mut_slice).collect();
            shard.observe(&mut groups);
            let [terminated, truncated] = &mut self.ends;
            shard.step(&self.action, StepBuffers::new(&mut self.reward, terminated, truncated));
        }
    }
}

/// Trains for about `seconds` (most of it in the parts, and half of it in f32 where the preset's precision differs) and measures.
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
    let mut side = Side::new(preset, &scene, threads)?;
    let peak_rss_mib = peak_rss_mib();
    let mut plain = None;
    if side.alone.products() != "f32" {
        let mut preset = preset.clone();
        preset.learn.precision = Precision::F32;
        plain = Some(Side::new(&preset, &scene, threads)?);
    }
    let shards = side.trainer.shards_mut();
    let mut drivers: Vec<_> =
        shards.iter().enumerate().map(|(k, shard)| Driver::new(&**shard, k as u32)).collect();
    let horizon = preset.learn.ppo.horizon;
    let mut workers = vec![(); threads];
    let mut env_s = 0.0;
    let mut iterations = 0;
    let begin = Instant::now();
    while iterations == 0 || begin.elapsed().as_secs_f64() < seconds {
        side.iterate(threads)?;
        let start = Instant::now();
        roll(&mut side.trainer, &mut drivers, &mut workers, horizon);
        env_s += start.elapsed().as_secs_f64();
        if let Some(plain) = &mut plain {
            plain.iterate(threads)?;
        }
        iterations += 1;
    }
    let samples = iterations as f64 * (preset.run.envs * horizon) as f64;
    let rates = |side: &Side| side.times.map(|time| samples / time);
    let [whole, forward, update] = rates(&side);
    let parts = samples / (env_s + side.times[1] + side.times[2]);
    let f32 = plain.as_ref().map(|plain| {
        let [plain_whole, _, plain_update] = rates(plain);
        F32Bench {
            samples_per_s: plain_whole,
            update_samples_per_s: plain_update,
            gain: whole / plain_whole,
            update_gain: update / plain_update,
        }
    });
    Ok(TrainBench {
        name: name.to_owned(),
        envs: preset.run.envs,
        shards: preset.run.shards,
        threads,
        isa: preset.isa().map_err(TrainError::Setup)?.to_string(),
        products: side.alone.products().to_owned(),
        iterations,
        samples_per_s: whole,
        env_samples_per_s: samples / env_s,
        forward_samples_per_s: forward,
        update_samples_per_s: update,
        parts_samples_per_s: parts,
        ratio: whole / parts,
        f32,
        peak_rss_mib,
    })
}

/// Lets every driver step its shard through a horizon.
fn roll(trainer: &mut Trainer, drivers: &mut [Driver], workers: &mut [()], horizon: usize) {
    let items = drivers.iter_mut().zip(trainer.shards_mut()).collect();
    for_each(workers, items, |(), (driver, shard)| driver.roll(&mut **shard, horizon));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_preset_with_a_style_reward_is_measured_with_it() {
        let sets = ["run.envs=16", "run.shards=1", "learn.ppo.minibatches=2", "learn.precision=\"f32\""];
        let side = |name: &str| {
            let preset = RunPreset::resolve(name, &sets.map(str::to_owned)).expect(name);
            Side::new(&preset, &Scene::load(&preset).expect(name), 1).expect(name)
        };
        let mut amp = side("amp");
        // The whole and the parts alone.
        assert!(amp.trainer.learner().learned_reward().is_some() && amp.alone.learned_reward().is_some());
        amp.iterate(1).expect("one more iteration");
        assert!(side("pure_rl").alone.learned_reward().is_none());
    }
}
