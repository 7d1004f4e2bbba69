//! The PPO update: minibatches of units, gradients per slice, reduction in slice order, Adam.

mod mirrored;
mod reduce;
mod slice;

use paid_lanes::rng::Rng;
use paid_policy::Mirrors;

use crate::config::PpoConfig;
use crate::model::Model;
use crate::operands::Operands;
use crate::ranks::Ranks;
use crate::rollout::{RolloutLayout, World};
use crate::shard::Shard;
use crate::stats::UpdateStats;
use reduce::{step, sum_ranks, sum_slices};
use slice::{Shared, minibatch_gradient};

pub use reduce::Gradients;
pub use slice::Worker;
pub(crate) use slice::sequence;

/// What persists between updates in addition to the models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Learning rate now.
    pub learning_rate: f64,
    /// Gradient steps taken.
    pub adam_step: u64,
    /// Order of minibatches.
    pub shuffle: Rng,
}

/// The networks that an update changes, and what computes their products.
#[derive(Debug)]
pub struct Networks<'a> {
    /// Policy.
    pub actor: &'a mut Model,
    /// Value functions.
    pub critics: &'a mut [Model],
    /// The weights that the products read, made from the models before each minibatch.
    pub operands: &'a mut Operands,
}

/// What a horizon left, here and on other ranks.
#[derive(Clone, Copy, Debug)]
pub struct Horizon<'a> {
    /// This rank's shards.
    pub shards: &'a [Shard],
    /// All shards.
    pub world: &'a World,
    /// The processes that train together.
    pub ranks: &'a dyn Ranks,
    /// Mean of all advantages and one over their standard deviation.
    pub advantage: (f64, f64),
    /// The mirror images of the samples, observations normalized as they were collected; `None` if the loss is off.
    pub mirrors: Option<&'a Mirrors>,
    /// Weight of the imitation loss now; 0 without a teacher.
    pub teacher: f64,
}

impl Horizon<'_> {
    /// This rank's units of a minibatch, by its own shards' numbers.
    fn own(&self, batch: &[(usize, usize)]) -> Vec<(usize, usize)> {
        let own = |&(k, unit): &(usize, usize)| {
            let k = k.checked_sub(self.world.first)?;
            (k < self.shards.len()).then_some((k, unit))
        };
        batch.iter().filter_map(own).collect()
    }
}

/// Runs epochs and minibatches over what the shards collected.
pub fn update(
    config: &PpoConfig,
    networks: Networks<'_>,
    schedule: &mut Schedule,
    horizon: Horizon<'_>,
    gradients: &mut Gradients,
    workers: &mut [Worker],
) -> UpdateStats {
    let Networks { actor, critics, operands } = networks;
    let Horizon { shards, world, ranks, advantage, mirrors, teacher } = horizon;
    let mut units = world.units();
    let old_log_std = actor.log_std().to_vec();
    let minibatches = minibatches(config, world);
    let mut totals = UpdateStats::default();
    for _ in 0..config.epochs {
        let shuffled = shuffle(&mut units, world, minibatches, config.balanced, &mut schedule.shuffle);
        for batch in shuffled {
            operands.refresh(core::iter::once(&*actor).chain(&*critics), workers);
            let step_number = schedule.adam_step as usize;
            let shared = Shared {
                config,
                actor,
                critics,
                operands,
                old_log_std: &old_log_std,
                shards,
                advantage,
                mirrors: mirrors.map(|mirrors| (mirrors, step_number)),
                teacher,
            };
            let weight = 1.0 / world.samples(&batch) as f64;
            let own = horizon.own(&batch);
            // A rank has its share of the slices: each costs a gradient to fill and to sum.
            let slices = config.slices.div_ceil(ranks.count()).min(own.len()).max(1);
            let mut losses =
                minibatch_gradient(&shared, (&own, weight, slices), ranks.rank() == 0, gradients, workers);
            let squares = sum_slices((actor, critics), gradients, slices, workers);
            let squares =
                if ranks.count() > 1 { sum_ranks(ranks, gradients, &mut losses, workers) } else { squares };
            if config.adaptive_learning_rate && losses.kl.is_finite() {
                schedule.learning_rate = adapted(config, schedule.learning_rate, losses.kl);
            }
            step(config, (actor, critics), schedule, gradients, squares, workers, &mut totals);
            totals.surrogate_loss += losses.surrogate_loss;
            totals.value_loss += losses.value_loss;
            totals.learned_value_loss += losses.learned_value_loss;
            totals.mirror_loss += losses.mirror_loss;
            totals.teacher_loss += losses.teacher_loss;
            totals.kl += losses.kl;
            totals.clip_fraction += losses.clip_fraction;
        }
    }
    let count = (config.epochs * minibatches) as f64;
    let taken = totals.steps.max(1) as f64;
    UpdateStats {
        surrogate_loss: totals.surrogate_loss / count,
        value_loss: totals.value_loss / count,
        learned_value_loss: totals.learned_value_loss / count,
        mirror_loss: totals.mirror_loss / count,
        teacher_loss: totals.teacher_loss / count,
        kl: totals.kl / count,
        clip_fraction: totals.clip_fraction / count,
        grad_norm: totals.grad_norm / taken,
        ..totals
    }
}

/// rsl_rl's schedule: a divergence above twice the target shrinks the rate by 1.5, below half of it grows it by 1.5.
fn adapted(config: &PpoConfig, rate: f64, kl: f64) -> f64 {
    if kl > 2.0 * config.target_kl {
        (rate / 1.5).max(config.min_learning_rate)
    } else if kl > 0.0 && kl < 0.5 * config.target_kl {
        (rate * 1.5).min(config.max_learning_rate)
    } else {
        rate
    }
}

/// As many minibatches as configured, or as get at least one unit each: a minibatch without a sample has no mean.
fn minibatches(config: &PpoConfig, world: &World) -> usize {
    let units = world.layouts.iter().map(RolloutLayout::units);
    let most = if config.balanced { units.min().unwrap_or(0) } else { units.sum() };
    config.minibatches.min(most)
}

/// The units of each minibatch, in a new order: of all units, or the same share of every shard's.
fn shuffle(
    units: &mut [(usize, usize)],
    world: &World,
    minibatches: usize,
    balanced: bool,
    rng: &mut Rng,
) -> Vec<Vec<(usize, usize)>> {
    let part = |units: &[(usize, usize)], k: usize| {
        units[k * units.len() / minibatches..(k + 1) * units.len() / minibatches].to_vec()
    };
    if !balanced {
        for i in (1..units.len()).rev() {
            units.swap(i, rng.below(i + 1));
        }
        return (0..minibatches).map(|k| part(units, k)).collect();
    }
    let mut batches = vec![Vec::new(); minibatches];
    let mut rest = units;
    for layout in &world.layouts {
        let (shard, others) = rest.split_at_mut(layout.units());
        for i in (1..shard.len()).rev() {
            shard.swap(i, rng.below(i + 1));
        }
        for (k, batch) in batches.iter_mut().enumerate() {
            batch.extend(part(shard, k));
        }
        rest = others;
    }
    batches
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rollout::RolloutLayout;

    #[test]
    fn no_minibatch_is_empty_where_shards_have_few_units() {
        // Sequences of 240 environments in blocks of 64: four units a shard.
        let layouts = vec![RolloutLayout::new(240, 24, 64, true); 8];
        let world = World { layouts, first: 0 };
        let config = |balanced| PpoConfig { minibatches: 8, balanced, ..PpoConfig::default() };
        assert_eq!([true, false].map(|balanced| minibatches(&config(balanced), &world)), [4, 8]);
        let batches = shuffle(&mut world.units(), &world, 4, true, &mut Rng::new(1, 0, 0));
        assert!(batches.iter().all(|batch| batch.len() == 8), "{batches:?}");
    }

    #[test]
    fn a_balanced_minibatch_has_equally_many_units_of_every_shard_and_each_unit_is_in_one() {
        let layouts = vec![RolloutLayout::new(64, 6, 32, false); 3];
        let world = World { layouts, first: 0 };
        let mut units = world.units();
        let before = units.clone();
        let batches = shuffle(&mut units, &world, 4, true, &mut Rng::new(1, 0, 0));
        for batch in &batches {
            // 12 units a shard in 4 minibatches.
            for shard in 0..3 {
                assert_eq!(batch.iter().filter(|(k, _)| *k == shard).count(), 3, "{batch:?}");
            }
        }
        let mut all = batches.concat();
        assert_ne!(all, before);
        all.sort_unstable();
        assert_eq!(all, before);
    }
}
