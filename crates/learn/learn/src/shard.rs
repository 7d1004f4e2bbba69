//! One shard of environments: its rollout, recurrent states and the collection of a horizon.

use std::time::Instant;

use crate::gae::GaeConfig;
use crate::gaussian::{NoiseKey, sample};
use crate::learned_reward::{RewardRole, RewardStream};
use crate::model::Model;
use crate::operands::Operands;
use crate::rollout::{Rollout, RolloutLayout, block_mut, unit_ref};
use crate::teacher::Teacher;
use crate::transitions::Transitions;
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{State, StepWorkspace};
use paid_policy::normalizer::{Normalizer, NormalizerBatch};
use paid_policy::{ObservationGroup, StepBuffers, VecEnv};

/// What a shard keeps between horizons, and its scratch.
#[derive(Clone, Debug)]
pub struct Shard {
    /// Samples of the last horizon.
    pub rollout: Rollout,
    /// Recurrent states of the actor now, per block.
    pub actor_state: Vec<State<f32>>,
    /// Recurrent states of each critic now, per block.
    pub critic_states: Vec<Vec<State<f32>>>,
    /// The actor's at the start of the horizon.
    pub actor_start: Vec<State<f32>>,
    /// The critics' at the start of the horizon.
    pub critic_starts: Vec<Vec<State<f32>>>,
    /// Further observation groups, rewards and ends of the last horizon.
    pub transitions: Transitions,
    /// What the policy's normalizer saw.
    pub policy_seen: NormalizerBatch,
    /// What the critic's normalizer saw.
    pub critic_seen: NormalizerBatch,
    /// Counts and times of the last horizon.
    pub stats: ShardStats,
    raw_policy: Vec<f32>,
    raw_critic: Vec<f32>,
    taught: Vec<f32>,
    action: Vec<f32>,
    reward: Vec<f32>,
    learned_reward: Vec<f32>,
    terminated: Vec<u8>,
    truncated: Vec<u8>,
}

/// Counts and times of one shard's horizon.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShardStats {
    /// Sum of the task's rewards.
    pub reward: f64,
    /// Sum of the learned rewards, before any weight.
    pub learned_reward: f64,
    /// Episodes that failed.
    pub terminated: u64,
    /// Episodes that were cut.
    pub truncated: u64,
    /// Observations and rewards that were not finite; replaced by zero.
    pub non_finite: u64,
    /// Sum and sum of squares of the advantages.
    pub advantage: (f64, f64),
    /// Time in the environment `[s]`.
    pub env_s: f64,
    /// Time in normalization `[s]`.
    pub normalize_s: f64,
    /// Time in the networks and in sampling `[s]`.
    pub forward_s: f64,
}

impl ShardStats {
    /// Numbers of [`ShardStats::numbers`].
    const NUMBERS: usize = 10;

    /// As numbers, for another process.
    fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { reward, learned_reward, terminated, truncated, non_finite, advantage, .. } = *self;
        let [terminated, truncated, non_finite] = [terminated, truncated, non_finite].map(|n| n as f64);
        [
            reward,
            learned_reward,
            terminated,
            truncated,
            non_finite,
            advantage.0,
            advantage.1,
            self.env_s,
            self.normalize_s,
            self.forward_s,
        ]
    }

    fn from_numbers(numbers: [f64; Self::NUMBERS]) -> Self {
        let [reward, learned_reward, terminated, truncated, non_finite, sum, squares, times @ ..] = numbers;
        let [terminated, truncated, non_finite] = [terminated, truncated, non_finite].map(|n| n as u64);
        let [env_s, normalize_s, forward_s] = times;
        let advantage = (sum, squares);
        Self {
            reward,
            learned_reward,
            terminated,
            truncated,
            non_finite,
            advantage,
            env_s,
            normalize_s,
            forward_s,
        }
    }
}

/// One shard's statistics of a horizon, shared with all others.
#[derive(Clone, Debug)]
pub(crate) struct Seen {
    pub policy: NormalizerBatch,
    pub critic: NormalizerBatch,
    pub stats: ShardStats,
}

impl Seen {
    /// Appends what `shard` saw.
    pub fn put(shard: &Shard, out: &mut Vec<f64>) {
        out.extend(shard.policy_seen.numbers());
        out.extend(shard.critic_seen.numbers());
        out.extend(shard.stats.numbers());
    }

    /// Takes what [`Seen::put`] wrote, for observations of `features` (policy, critic).
    pub fn take([policy, critic]: [usize; 2], numbers: &mut impl Iterator<Item = f64>) -> Self {
        let policy = NormalizerBatch::from_numbers(policy, numbers);
        let critic = NormalizerBatch::from_numbers(critic, numbers);
        let stats = core::array::from_fn(|_| numbers.next().unwrap_or(0.0));
        Self { policy, critic, stats: ShardStats::from_numbers(stats) }
    }
}

/// What all shards read while they collect.
#[derive(Clone, Copy, Debug)]
pub struct Collect<'a> {
    /// Policy.
    pub actor: &'a Model,
    /// Value functions: the task's, then that of the learned reward if it has its own.
    pub critics: &'a [Model],
    /// Their weights in the products.
    pub operands: &'a Operands,
    /// A reward that the learner computes.
    pub learned: Option<&'a RewardStream>,
    /// A policy to imitate, while that counts, and the number of its observation group.
    pub teacher: Option<(&'a Teacher, usize)>,
    /// Normalizer of the policy's observation.
    pub policy_normalizer: &'a Normalizer,
    /// Normalizer of the critic's observation.
    pub critic_normalizer: &'a Normalizer,
    /// Discount and decay.
    pub gae: GaeConfig,
    /// Seed, and step of the first sample; the first environment is the shard's own.
    pub noise: NoiseKey,
}

impl Shard {
    /// A shard of `envs` environments, at the start of episodes.
    pub fn new(layout: RolloutLayout, actor: &Model, critics: &[Model]) -> Self {
        let (n, actions) = (layout.envs, actor.net.output);
        let states = |model: &Model| -> Vec<State<f32>> {
            layout.blocks.iter().map(|block| model.net.initial_state(block.len())).collect()
        };
        let critic_states: Vec<_> = critics.iter().map(&states).collect();
        let actor_state = states(actor);
        let critic_obs = critics[0].net.input;
        Self {
            actor_start: actor_state.clone(),
            critic_starts: critic_states.clone(),
            actor_state,
            critic_states,
            transitions: Transitions::new(n, layout.horizon, &[]),
            policy_seen: NormalizerBatch::default(),
            critic_seen: NormalizerBatch::default(),
            stats: ShardStats::default(),
            raw_policy: vec![0.0; actor.net.input * n],
            raw_critic: vec![0.0; critic_obs * n],
            taught: Vec::new(),
            action: vec![0.0; actions * n],
            reward: vec![0.0; n],
            learned_reward: Vec::new(),
            terminated: vec![0; n],
            truncated: vec![0; n],
            rollout: Rollout::new(layout, [actor.net.input, critic_obs, actions], critics.len()),
        }
    }

    /// Makes space for the environment's further observation groups.
    pub fn prepare(&mut self, further: &[ObservationGroup]) {
        if self.transitions.groups() != further {
            let layout = &self.rollout.layout;
            self.transitions = Transitions::new(layout.envs, layout.horizon, further);
        }
    }

    /// Collects one horizon from `env` and estimates advantages.
    pub fn collect(
        &mut self,
        shared: Collect<'_>,
        env: &mut (impl VecEnv + ?Sized),
        work: &mut StepWorkspace<f32>,
    ) {
        self.policy_seen = NormalizerBatch::new(shared.actor.net.input);
        self.critic_seen = NormalizerBatch::new(self.rollout.dims[1]);
        self.stats = ShardStats::default();
        self.actor_start.clone_from(&self.actor_state);
        self.critic_starts.clone_from(&self.critic_states);
        let taught = if shared.teacher.is_some() { self.rollout.action.len() } else { 0 };
        self.rollout.taught.resize(taught, 0.0);
        for t in 0..self.rollout.layout.horizon {
            self.observe(t, env);
            for b in 0..self.rollout.layout.blocks.len() {
                self.act(shared, t, b, work);
            }
            let out = StepBuffers {
                reward: &mut self.reward,
                terminated: &mut self.terminated,
                truncated: &mut self.truncated,
            };
            self.stats.env_s += timed(|| env.step(&self.action, out));
            self.record(t);
        }
        self.observe(self.rollout.layout.horizon, env);
        self.bootstrap(shared, work);
        let weights = match shared.learned {
            Some(stream) => {
                self.compute_reward(stream);
                stream.role.advantage_weights()
            }
            None => vec![1.0],
        };
        self.stats.advantage = self.rollout.estimate_advantages(shared.gae, &weights);
        self.stats.non_finite += self.policy_seen.non_finite + self.critic_seen.non_finite;
    }

    /// Takes the observations before step `t`.
    fn observe(&mut self, t: usize, env: &mut (impl VecEnv + ?Sized)) {
        let mut groups: Vec<&mut [f32]> = vec![&mut self.raw_policy, &mut self.raw_critic];
        groups.extend(self.transitions.observations_mut(t));
        self.stats.env_s += timed(|| env.observe(&mut groups));
        for x in groups.into_iter().skip(2).flatten() {
            if !x.is_finite() {
                *x = 0.0;
                self.stats.non_finite += 1;
            }
        }
    }

    /// Computes the learned reward of the horizon and puts it where its role says.
    fn compute_reward(&mut self, stream: &RewardStream) {
        let r = &mut self.rollout;
        self.learned_reward.resize(r.layout.samples(), 0.0);
        stream.reward.reward(&self.transitions, &mut self.learned_reward);
        for t in 0..r.layout.horizon {
            for (b, block) in r.layout.blocks.iter().enumerate() {
                let first = r.layout.place(t, b).range().start;
                for i in 0..block.len() {
                    let mut learned = self.learned_reward[t * r.layout.envs + block.start + i];
                    if !learned.is_finite() {
                        learned = 0.0;
                        self.stats.non_finite += 1;
                    }
                    self.stats.learned_reward += f64::from(learned);
                    match stream.role {
                        RewardRole::Mixed { task, learned: factor } => {
                            let reward = &mut r.streams[0].reward[first + i];
                            *reward = task * *reward + factor * learned;
                        }
                        RewardRole::OwnCritic { .. } => r.streams[1].reward[first + i] = learned,
                    }
                }
            }
        }
    }

    /// Normalizes, evaluates all networks and draws actions for block `b` at step `t`.
    fn act(&mut self, shared: Collect<'_>, t: usize, b: usize, work: &mut StepWorkspace<f32>) {
        let r = &mut self.rollout;
        let [policy_obs, critic_obs, actions] = r.dims;
        let n = r.layout.envs;
        let place = r.layout.place(t, b);
        let first = r.layout.blocks[b].start;
        let start = Instant::now();
        let raw = Mat::new(&self.raw_policy, policy_obs, n, n).columns(first, place.width);
        let out = block_mut(&mut r.policy_obs, policy_obs, place);
        shared.policy_normalizer.apply(raw, out, Some(&mut self.policy_seen));
        let raw = Mat::new(&self.raw_critic, critic_obs, n, n).columns(first, place.width);
        let out = block_mut(&mut r.critic_obs, critic_obs, place);
        shared.critic_normalizer.apply(raw, out, Some(&mut self.critic_seen));
        let normalized = Instant::now();
        self.stats.normalize_s += (normalized - start).as_secs_f64();

        let columns = |data, rows| unit_ref(data, rows, place).columns(place.column, place.width);
        let actor = shared.actor;
        let mean = block_mut(&mut r.mean, actions, place);
        let x = columns(&r.policy_obs, policy_obs);
        let weights = shared.operands.weights(0, actor);
        actor.net.step(weights, x, &mut self.actor_state[b], mean, work);
        for (k, critic) in shared.critics.iter().enumerate() {
            let value = MatMut::new(&mut r.streams[k].value[place.range()], 1, place.width, place.width);
            let x = columns(&r.critic_obs, critic_obs);
            let weights = shared.operands.weights(k + 1, critic);
            critic.net.step(weights, x, &mut self.critic_states[k][b], value, work);
        }
        if let Some((teacher, group)) = shared.teacher {
            let raw = self.transitions.before(group, t).columns(first, place.width);
            teacher.act(raw, block_mut(&mut r.taught, actions, place), &mut self.taught, work);
        }
        let key = NoiseKey {
            first_env: shared.noise.first_env + first as u32,
            step: shared.noise.step + t as u64,
            ..shared.noise
        };
        let action = block_mut(&mut r.action, actions, place);
        let log_prob = &mut r.log_prob[place.range()];
        sample(key, columns(&r.mean, actions), actor.log_std(), action, log_prob);
        let drawn = columns(&r.action, actions);
        for a in 0..actions {
            self.action[a * n + first..a * n + first + place.width].copy_from_slice(drawn.row(a));
        }
        self.stats.forward_s += normalized.elapsed().as_secs_f64();
    }

    /// Stores what step `t` returned and clears the memory of environments whose episode ended.
    fn record(&mut self, t: usize) {
        let r = &mut self.rollout;
        for b in 0..r.layout.blocks.len() {
            let first = r.layout.blocks[b].start;
            let place = r.layout.place(t, b);
            for i in 0..place.width {
                let (e, s) = (first + i, place.range().start + i);
                let reward = self.reward[e];
                let finite = reward.is_finite();
                let reward = if finite { reward } else { 0.0 };
                r.streams[0].reward[s] = reward;
                self.stats.non_finite += u64::from(!finite);
                self.stats.reward += f64::from(reward);
                let (terminated, truncated) = (self.terminated[e] != 0, self.truncated[e] != 0);
                r.done[s] = u8::from(terminated) | u8::from(truncated) << 1;
                self.transitions.record(t, e, reward, r.done[s]);
                let ended = terminated || truncated;
                if t + 1 < r.layout.horizon {
                    r.mask[r.layout.place(t + 1, b).range().start + i] = if ended { 0.0 } else { 1.0 };
                }
                if ended {
                    self.stats.terminated += u64::from(terminated);
                    self.stats.truncated += u64::from(!terminated);
                    self.actor_state[b].reset(i);
                    for states in &mut self.critic_states {
                        states[b].reset(i);
                    }
                }
            }
        }
    }

    /// Values after the last step. The critics' memory does not move: the next horizon starts from this observation.
    fn bootstrap(&mut self, shared: Collect<'_>, work: &mut StepWorkspace<f32>) {
        let start = Instant::now();
        let n = self.rollout.layout.envs;
        let rows = self.rollout.dims[1];
        let mut normalized = vec![0.0; rows * n];
        shared.critic_normalizer.apply(
            Mat::new(&self.raw_critic, rows, n, n),
            MatMut::new(&mut normalized, rows, n, n),
            None,
        );
        for (b, block) in self.rollout.layout.blocks.iter().enumerate() {
            for (k, critic) in shared.critics.iter().enumerate() {
                let mut state = self.critic_states[k][b].clone();
                let x = Mat::new(&normalized, rows, n, n).columns(block.start, block.len());
                let last_value = &mut self.rollout.streams[k].last_value[block.clone()];
                let out = MatMut::new(last_value, 1, block.len(), block.len());
                let weights = shared.operands.weights(k + 1, critic);
                critic.net.step(weights, x, &mut state, out, work);
            }
        }
        self.stats.forward_s += start.elapsed().as_secs_f64();
    }
}

fn timed(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}
