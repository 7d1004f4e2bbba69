//! A horizon from every shard, and what all of them saw.

use std::time::Instant;

use paid_policy::{Mirrors, ObservationGroup, VecEnv};

use super::{Learner, ShardError};
use crate::gae::GaeConfig;
use crate::gaussian::NoiseKey;
use crate::parallel::for_each;
use crate::ranks::gather_numbers;
use crate::rollout::{RolloutLayout, World};
use crate::shard::{Collect, Seen, Shard};
use crate::stats::CollectStats;

impl Learner {
    /// Collects a horizon from every shard and merges what the normalizers saw. Shards keep their order, number and sizes
    /// for the life of a learner.
    ///
    /// # Errors
    /// If a shard does not fit the learner.
    pub fn collect<E: VecEnv + ?Sized>(
        &mut self,
        envs: &mut [Box<E>],
        threads: usize,
    ) -> Result<CollectStats, ShardError> {
        let start = Instant::now();
        self.prepare_shards(envs)?;
        self.prepare_workers(threads);
        let models = core::iter::once(&self.actor).chain(&self.critics);
        self.operands.refresh(models, &mut self.workers);
        let further = self.shards.first().map_or(&[][..], |shard| shard.transitions.groups());
        let teacher = self.teacher.as_ref().filter(|(_, weight)| *weight > 0.0);
        let teacher = teacher.and_then(|(teacher, _)| Some((teacher, teacher.group(further)?)));
        let shared = Collect {
            actor: &self.actor,
            critics: &self.critics,
            operands: &self.operands,
            learned: self.learned.as_ref(),
            teacher,
            policy_normalizer: &self.policy_normalizer,
            critic_normalizer: &self.critic_normalizer,
            gae: GaeConfig { gamma: self.config.ppo.gamma, lambda: self.config.ppo.lambda },
            noise: NoiseKey { seed: self.seed, first_env: 0, step: self.env_steps },
        };
        let mut items = Vec::new();
        let mut first_env = self.world.first_env() as u32;
        for (shard, env) in self.shards.iter_mut().zip(envs.iter_mut()) {
            let shared = Collect { noise: NoiseKey { first_env, ..shared.noise }, ..shared };
            first_env += shard.rollout.layout.envs as u32;
            items.push((shared, shard, env));
        }
        for_each(&mut self.workers, items, |worker, (shared, shard, env)| {
            shard.collect(shared, env.as_mut(), &mut worker.step);
        });
        self.env_steps += self.config.ppo.horizon as u64;
        self.collected =
            self.mirrors.as_ref().filter(|_| self.config.ppo.mirror.weight > 0.0).map(|mirrors| {
                let observation = mirrors.observation.normalized(&self.policy_normalizer);
                Mirrors { observation, action: mirrors.action.clone() }
            });
        let seen = self.seen();
        self.policy_normalizer.merge(seen.iter().map(|seen| &seen.policy));
        self.critic_normalizer.merge(seen.iter().map(|seen| &seen.critic));
        let mut stats = CollectStats::default();
        self.advantages = [0.0; 3];
        for (Seen { stats: shard, .. }, layout) in seen.iter().zip(&self.world.layouts) {
            stats.samples += layout.samples();
            stats.mean_reward += shard.reward;
            stats.mean_learned_reward += shard.learned_reward;
            stats.terminated += shard.terminated;
            stats.truncated += shard.truncated;
            stats.non_finite += shard.non_finite;
            stats.env_s += shard.env_s;
            stats.normalize_s += shard.normalize_s;
            stats.forward_s += shard.forward_s;
            let (sum, squares) = shard.advantage;
            for (total, part) in self.advantages.iter_mut().zip([sum, squares, layout.samples() as f64]) {
                *total += part;
            }
        }
        stats.mean_reward /= stats.samples.max(1) as f64;
        stats.mean_learned_reward /= stats.samples.max(1) as f64;
        stats.wall_s = start.elapsed().as_secs_f64();
        Ok(stats)
    }

    /// What all shards of all ranks saw in the last horizon, in their order.
    fn seen(&self) -> Vec<Seen> {
        let mut numbers = Vec::new();
        self.shards.iter().for_each(|shard| Seen::put(shard, &mut numbers));
        let features = [self.actor.net.input, self.critics[0].net.input];
        let mut all = gather_numbers(&*self.ranks, &numbers).into_iter().flatten();
        self.world.layouts.iter().map(|_| Seen::take(features, &mut all)).collect()
    }

    /// How environments of a shard are cut into blocks.
    pub(crate) fn layout(&self, envs: usize) -> RolloutLayout {
        let ppo = &self.config.ppo;
        let sequences =
            self.actor.net.is_recurrent() || self.critics.iter().any(|critic| critic.net.is_recurrent());
        let block = if sequences { ppo.sequence_block } else { ppo.block };
        RolloutLayout::new(envs, ppo.horizon, block, sequences)
    }

    fn prepare_shards<E: VecEnv + ?Sized>(&mut self, envs: &[Box<E>]) -> Result<(), ShardError> {
        let sizes =
            |p: usize, c: usize, a: usize| format!("{p} policy features, {c} critic features, {a} actions");
        let want = sizes(self.actor.net.input, self.critics[0].net.input, self.actor.net.output);
        for (shard, env) in envs.iter().enumerate() {
            let found = sizes(env.policy_obs_dim(), env.critic_obs_dim(), env.action_dim());
            if found != want {
                return Err(ShardError { shard, expected: want, found });
            }
        }
        let further = |env: &E| env.observation_groups().split_off(2);
        let text = |groups: &[ObservationGroup]| {
            let names: Vec<_> = groups.iter().map(|g| format!("{} [{}]", g.name, g.size)).collect();
            format!("further groups ({})", names.join(", "))
        };
        let first = envs.first().map(|env| further(env)).unwrap_or_default();
        for (shard, env) in envs.iter().enumerate().skip(1) {
            let found = further(env);
            if found != first {
                return Err(ShardError { shard, expected: text(&first), found: text(&found) });
            }
        }
        if let Some((teacher, _)) = &self.teacher
            && teacher.group(&first).is_none()
        {
            return Err(ShardError { shard: 0, expected: teacher.wanted(), found: text(&first) });
        }
        if self.shards.is_empty() {
            let sizes: Vec<f64> = envs.iter().map(|env| env.num_envs() as f64).collect();
            let all = gather_numbers(&*self.ranks, &sizes);
            let first = all[..self.ranks.rank()].iter().map(Vec::len).sum();
            let layouts = all.into_iter().flatten().map(|envs| self.layout(envs as usize)).collect();
            self.world = World { layouts, first };
            for env in envs {
                let layout = self.layout(env.num_envs());
                self.shards.push(Shard::new(layout, &self.actor, &self.critics));
            }
        }
        let old: Vec<usize> = self.shards.iter().map(|shard| shard.rollout.layout.envs).collect();
        let new: Vec<usize> = envs.iter().map(|env| env.num_envs()).collect();
        if old != new {
            let shard = (0..old.len().max(new.len())).find(|&k| old.get(k) != new.get(k)).unwrap_or(0);
            let text = |sizes: &[usize]| {
                sizes.get(shard).map_or("no such shard".to_owned(), |n| format!("{n} environments"))
            };
            return Err(ShardError { shard, expected: text(&old), found: text(&new) });
        }
        for shard in &mut self.shards {
            shard.prepare(&first);
        }
        Ok(())
    }
}
