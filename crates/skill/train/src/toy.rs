//! A small known task for the tests: drive a point to the origin.

use paid_lanes::rng::Rng;
use paid_policy::{ObservationGroup, StepBuffers, VecEnv};
use paid_task::{BallCurriculum, SamplerState, TaskMetrics, TrainShard};

use crate::RunPreset;

/// Points on a line; the action is a velocity, the reward the negative squared distance.
pub struct Toy {
    x: Vec<f32>,
    age: Vec<u32>,
    rng: Rng,
    metrics: TaskMetrics,
    failures: Vec<f32>,
    sampler: SamplerState,
    /// Reward is not a number in one environment.
    pub broken: bool,
}

const LIMIT: u32 = 20;

impl Toy {
    pub fn new(envs: usize, number: u32) -> Self {
        Self {
            x: (0..envs).map(|e| e as f32 / envs as f32 - 0.5).collect(),
            age: vec![0; envs],
            rng: Rng::new(5, number, 0),
            metrics: TaskMetrics::default(),
            failures: vec![0.0; 2],
            sampler: SamplerState::uniform(1, 2),
            broken: false,
        }
    }

    /// Shards of a small preset.
    #[expect(clippy::vec_box, reason = "the learner takes boxed environments")]
    pub fn shards(preset: &RunPreset) -> Vec<Box<Self>> {
        let envs = preset.run.envs / preset.run.shards;
        (0..preset.run.shards).map(|k| Box::new(Self::new(envs, k as u32))).collect()
    }

    /// A preset of seconds.
    pub fn preset(more: &[&str]) -> RunPreset {
        let mut sets: Vec<String> = [
            "phases=[]",
            "run.envs=64",
            "run.shards=4",
            "run.iterations=6",
            "run.checkpoint_interval=2",
            "run.isa=portable",
            "learn.actor.hidden=[8]",
            "learn.critic.hidden=[8]",
            "learn.ppo.minibatches=2",
            "learn.ppo.epochs=2",
            // It has no sides.
            "learn.ppo.mirror.weight=0.0",
        ]
        .map(str::to_owned)
        .into();
        sets.extend(more.iter().map(|s| (*s).to_owned()));
        RunPreset::resolve("stage1", &sets).expect("preset")
    }
}

impl VecEnv for Toy {
    fn num_envs(&self) -> usize {
        self.x.len()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        ObservationGroup::policy_and_critic(2, 1)
    }
    fn action_dim(&self) -> usize {
        1
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        let n = self.x.len();
        for group in groups {
            group[..n].copy_from_slice(&self.x);
            // The policy sees noise too; the critic's group ends here.
            self.rng.fill_unit(&mut group[n..]);
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        for e in 0..self.x.len() {
            self.x[e] += 0.1 * actions[e].clamp(-2.0, 2.0);
            self.age[e] += 1;
            let reward = -self.x[e] * self.x[e];
            out.reward[e] = if self.broken && e == 0 { f32::NAN } else { reward };
            out.terminated[e] = u8::from(self.x[e].abs() > 1.0);
            out.truncated[e] = u8::from(out.terminated[e] == 0 && self.age[e] >= LIMIT);
            self.metrics.steps += 1;
            self.metrics.episode_return_sum += f64::from(reward);
            if out.terminated[e] + out.truncated[e] > 0 {
                self.failures[0] += f32::from(out.terminated[e]);
                self.metrics.episodes += 1;
                self.metrics.episode_steps += u64::from(self.age[e]);
                self.age[e] = 0;
                // The sampler decides where episodes begin, so that its state matters to the result.
                let side = self.sampler.draw(self.rng.unit()).1 as f32;
                self.x[e] = side - 0.5;
            }
        }
    }
    fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::new();
        for (x, age) in self.x.iter().zip(&self.age) {
            bytes.extend(x.to_le_bytes());
            bytes.extend(age.to_le_bytes());
        }
        for p in &self.sampler.probabilities {
            bytes.extend(p.to_le_bytes());
        }
        bytes.extend(self.rng.position().to_le_bytes());
        bytes
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        let expected = 8 * self.x.len() + 8 + 8;
        if bytes.len() != expected {
            return Err(format!("expected {expected} bytes, found {}", bytes.len()));
        }
        let word = |k: usize| [bytes[4 * k], bytes[4 * k + 1], bytes[4 * k + 2], bytes[4 * k + 3]];
        let n = self.x.len();
        for e in 0..n {
            self.x[e] = f32::from_le_bytes(word(2 * e));
            self.age[e] = u32::from_le_bytes(word(2 * e + 1));
        }
        for (k, p) in self.sampler.probabilities.iter_mut().enumerate() {
            *p = f32::from_le_bytes(word(2 * n + k));
        }
        let low = u64::from(u32::from_le_bytes(word(2 * n + 2)));
        let high = u64::from(u32::from_le_bytes(word(2 * n + 3)));
        self.rng.seek(high << 32 | low);
        Ok(())
    }
}

impl TrainShard for Toy {
    fn take_metrics(&mut self) -> TaskMetrics {
        std::mem::take(&mut self.metrics)
    }
    fn take_failures(&mut self) -> Vec<f32> {
        std::mem::replace(&mut self.failures, vec![0.0; 2])
    }
    fn new_sampler(&self) -> SamplerState {
        SamplerState::uniform(1, 2)
    }
    fn set_sampler(&mut self, sampler: &SamplerState) {
        self.sampler = sampler.clone();
    }
    fn set_ball_curriculum(&mut self, _: BallCurriculum) {}
}
