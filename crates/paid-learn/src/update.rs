//! The PPO update: minibatches of units, gradients per slice, reduction in slice order, Adam.

use paid_lanes::rng::Rng;

use crate::adam::{AdamStep, Reduce};
use crate::config::PpoConfig;
use crate::gaussian::{ActorBatch, ActorLoss, ActorLossConfig, actor_loss};
use crate::model::Model;
use crate::net::{Sequence, Steps, TrainNetwork, TrainWorkspace};
use crate::operands::Operands;
use crate::parallel::for_each;
use crate::ranks::Ranks;
use crate::rollout::{World, unit_ref};
use crate::shard::Shard;
use crate::stats::UpdateStats;
use crate::value_loss::{ValueBatch, value_loss};
use paid_policy::element::Element;
use paid_policy::net::State;

/// Parameters that one thread reduces or steps at a time.
const RANGE: usize = 16 * 1024;

/// Scratch of one thread.
#[derive(Clone, Debug, Default)]
pub struct Worker {
    train: TrainWorkspace<f32>,
    dlog_prob: Vec<f32>,
    /// Scratch of collection.
    pub step: paid_policy::net::StepWorkspace<f32>,
}

/// Gradients of the slices and their sums; kept so that updates need not allocate them.
#[derive(Clone, Debug, Default)]
pub struct Gradients {
    actor: NetworkGradient,
    critics: Vec<NetworkGradient>,
    /// What ranks exchange.
    flat: Vec<f32>,
}

/// Gradient of one network.
#[derive(Clone, Debug, Default)]
struct NetworkGradient {
    /// One per slice.
    slices: Vec<Vec<f32>>,
    /// Their sum.
    total: Vec<f32>,
}

impl Gradients {
    /// The actor's, then the critics'.
    fn networks_mut(&mut self) -> impl Iterator<Item = &mut NetworkGradient> {
        core::iter::once(&mut self.actor).chain(&mut self.critics)
    }
}

/// What persists between updates, besides the models.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Schedule {
    /// Learning rate now.
    pub learning_rate: f64,
    /// Gradient steps taken.
    pub adam_step: u64,
    /// Order of minibatches.
    pub shuffle: Rng,
}

/// Which network a slice trains, and where its loss goes.
enum Target<'a> {
    Actor(&'a mut ActorLoss),
    Critic(usize, &'a mut f64),
}

/// One slice of a minibatch for one network.
struct Slice<'a> {
    target: Target<'a>,
    units: &'a [(usize, usize)],
    grads: &'a mut [f32],
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

/// What the slices of an update read.
struct Shared<'a> {
    config: &'a PpoConfig,
    actor: &'a Model,
    critics: &'a [Model],
    operands: &'a Operands,
    old_log_std: &'a [f32],
    shards: &'a [Shard],
    advantage: (f64, f64),
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
    let Horizon { shards, world, ranks, advantage } = horizon;
    let mut units = world.units();
    let old_log_std = actor.log_std().to_vec();
    let minibatches = config.minibatches.min(units.len());
    let mut totals = UpdateStats::default();
    for _ in 0..config.epochs {
        let shuffled = shuffle(&mut units, world, minibatches, config.balanced, &mut schedule.shuffle);
        for batch in shuffled {
            operands.refresh(core::iter::once(&*actor).chain(&*critics), workers);
            let shared =
                Shared { config, actor, critics, operands, old_log_std: &old_log_std, shards, advantage };
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

/// Gradients of this rank's units of one minibatch, one for each of so many slices, and their share of its mean losses. `weight` is one over the samples of
/// the whole minibatch.
fn minibatch_gradient(
    shared: &Shared<'_>,
    (units, weight, slices): (&[(usize, usize)], f64, usize),
    with_entropy: bool,
    gradients: &mut Gradients,
    workers: &mut [Worker],
) -> UpdateStats {
    gradients.critics.resize_with(shared.critics.len(), NetworkGradient::default);
    let models = core::iter::once(shared.actor).chain(shared.critics);
    for (gradient, model) in gradients.networks_mut().zip(models) {
        gradient.slices.resize_with(slices.max(gradient.slices.len()), Vec::new);
        for slice in &mut gradient.slices {
            slice.resize(model.layout.len(), 0.0);
        }
    }
    let mut sums = vec![ActorLoss::default(); slices];
    let mut values = vec![vec![0.0; slices]; shared.critics.len()];
    let mut jobs = Vec::new();
    // The critic is the larger network: its slices go first, so that the small ones even out the ends.
    let part = |s: usize| &units[s * units.len() / slices..(s + 1) * units.len() / slices];
    for (k, (gradient, values)) in gradients.critics.iter_mut().zip(&mut values).enumerate() {
        for (s, (grads, value)) in gradient.slices.iter_mut().zip(values).enumerate() {
            jobs.push(Slice { target: Target::Critic(k, value), units: part(s), grads });
        }
    }
    for (s, (grads, sums)) in gradients.actor.slices.iter_mut().zip(&mut sums).enumerate() {
        jobs.push(Slice { target: Target::Actor(sums), units: part(s), grads });
    }
    for_each(workers, jobs, |worker, slice| train_slice(shared, weight, worker, slice));
    // Once in the sum over all ranks.
    let entropy_gradient = if with_entropy { shared.config.entropy as f32 } else { 0.0 };
    for g in &mut gradients.actor.slices[0][shared.actor.net.layout().len()..] {
        *g -= entropy_gradient;
    }
    let mut losses = UpdateStats::default();
    for s in 0..slices {
        losses.surrogate_loss += sums[s].surrogate * weight;
        losses.kl += sums[s].kl * weight;
        losses.clip_fraction += sums[s].clipped * weight;
        losses.value_loss += values[0][s] * weight;
        losses.learned_value_loss += values.get(1).map_or(0.0, |values| values[s] * weight);
    }
    losses
}

fn train_slice(shared: &Shared<'_>, weight: f64, worker: &mut Worker, slice: Slice<'_>) {
    let Slice { mut target, units, grads } = slice;
    grads.fill(0.0);
    for &(k, unit) in units {
        let shard = &shared.shards[k];
        match &mut target {
            Target::Actor(sums) => {
                let loss = train_actor(shared, weight, shard, unit, grads, worker);
                sums.surrogate += loss.surrogate;
                sums.kl += loss.kl;
                sums.clipped += loss.clipped;
            }
            Target::Critic(critic, value) => {
                **value += train_critic(shared, *critic, weight, (shard, unit), grads, worker);
            }
        }
    }
}

/// The stored samples of a unit as input of a network.
fn sequence<'a>(
    shard: &'a Shard,
    obs: &'a [f32],
    rows: usize,
    unit: usize,
    starts: &'a [State<f32>],
) -> Sequence<'a, f32> {
    let r = &shard.rollout;
    let (block, place) = r.layout.unit(unit);
    let steps =
        Steps { steps: place.stride / place.width, width: place.width, mask: &r.mask[place.unit_range()] };
    Sequence { input: unit_ref(obs, rows, place), steps, state: &starts[block] }
}

fn train_actor(
    shared: &Shared<'_>,
    weight: f64,
    shard: &Shard,
    unit: usize,
    grads: &mut [f32],
    worker: &mut Worker,
) -> ActorLoss {
    let r = &shard.rollout;
    let [rows, _, actions] = r.dims;
    let (_, place) = r.layout.unit(unit);
    let config = ActorLossConfig {
        clip: shared.config.clip,
        advantage_mean: shared.advantage.0,
        advantage_scale: shared.advantage.1,
        weight,
    };
    let net = &shared.actor.net;
    let (grads, dlog_std) = grads.split_at_mut(net.layout().len());
    let mut total = ActorLoss::default();
    let Worker { train, dlog_prob, .. } = worker;
    dlog_prob.resize(place.stride, 0.0);
    let sequence = sequence(shard, &r.policy_obs, rows, unit, &shard.actor_start);
    let weights = shared.operands.weights(0, shared.actor);
    net.train(weights, grads, sequence, train, &mut |columns, mean, dmean| {
        let samples = place.unit + columns.start..place.unit + columns.end;
        let batch = ActorBatch {
            action: unit_ref(&r.action, actions, place).columns(columns.start, columns.len()),
            old_mean: unit_ref(&r.mean, actions, place).columns(columns.start, columns.len()),
            old_log_std: shared.old_log_std,
            old_log_prob: &r.log_prob[samples.clone()],
            advantage: &r.advantage[samples],
        };
        let loss = actor_loss(config, mean, shared.actor.log_std(), batch, dmean, dlog_std, dlog_prob);
        total.surrogate += loss.surrogate;
        total.kl += loss.kl;
        total.clipped += loss.clipped;
    });
    total
}

fn train_critic(
    shared: &Shared<'_>,
    critic: usize,
    weight: f64,
    (shard, unit): (&Shard, usize),
    grads: &mut [f32],
    worker: &mut Worker,
) -> f64 {
    let r = &shard.rollout;
    let (_, place) = r.layout.unit(unit);
    let clip = shared.config.clip_value_loss.then_some(shared.config.clip);
    let weight = weight * shared.config.value_loss;
    let mut total = 0.0;
    let sequence = sequence(shard, &r.critic_obs, r.dims[1], unit, &shard.critic_starts[critic]);
    let (model, stream) = (&shared.critics[critic], &r.streams[critic]);
    let weights = shared.operands.weights(critic + 1, model);
    model.net.train(weights, grads, sequence, &mut worker.train, &mut |columns, value, mut dvalue| {
        let samples = place.unit + columns.start..place.unit + columns.end;
        let batch =
            ValueBatch { old_value: &stream.value[samples.clone()], returns: &stream.returns[samples] };
        total += value_loss(clip, weight, value.row(0), batch, dvalue.row(0));
    });
    total
}

/// Sums the slices of every network; the sum of the squares over all of them.
fn sum_slices(
    (actor, critics): (&Model, &[Model]),
    gradients: &mut Gradients,
    slices: usize,
    workers: &mut [Worker],
) -> f64 {
    let mut ranges = 0;
    let models = core::iter::once(actor).chain(critics);
    for (gradient, model) in gradients.networks_mut().zip(models) {
        gradient.total.resize(model.layout.len(), 0.0);
        ranges += gradient.total.len().div_ceil(RANGE);
    }
    let mut squares = vec![0.0; ranges];
    let mut items = Vec::new();
    let mut places = squares.iter_mut();
    for NetworkGradient { slices: parts, total } in gradients.networks_mut() {
        for (k, total) in total.chunks_mut(RANGE).enumerate() {
            let parts: Vec<&[f32]> =
                parts[..slices].iter().map(|part| &part[k * RANGE..k * RANGE + total.len()]).collect();
            items.extend(places.next().map(|place| (total, parts, place)));
        }
    }
    for_each(workers, items, |_, (total, parts, place): (_, Vec<&[f32]>, &mut f64)| {
        *place = f32::launch(Reduce { total, parts: &parts });
    });
    squares.iter().sum()
}

/// Sums gradients and losses over the ranks, in one message; the sum of the gradients' squares.
fn sum_ranks(
    ranks: &dyn Ranks,
    gradients: &mut Gradients,
    losses: &mut UpdateStats,
    workers: &mut [Worker],
) -> f64 {
    let mut flat = core::mem::take(&mut gradients.flat);
    flat.clear();
    gradients.networks_mut().for_each(|network| flat.extend_from_slice(&network.total));
    let weights = flat.len();
    flat.extend(losses.sums_mut().map(|x| *x as f32));
    ranks.sum(&mut flat);
    let (mut sums, of_losses) = flat.split_at(weights);
    for (loss, sum) in losses.sums_mut().into_iter().zip(of_losses) {
        *loss = f64::from(*sum);
    }
    let mut items = Vec::new();
    for NetworkGradient { total, .. } in gradients.networks_mut() {
        for total in total.chunks_mut(RANGE) {
            let (sum, rest) = sums.split_at(total.len());
            items.push((total, sum));
            sums = rest;
        }
    }
    let mut squares = vec![0.0; items.len()];
    let items = items.into_iter().zip(&mut squares).collect();
    for_each(workers, items, |_, ((total, sum), place): ((_, &[f32]), &mut f64)| {
        *place = f32::launch(Reduce { total, parts: &[sum] });
    });
    gradients.flat = flat;
    squares.iter().sum()
}

/// Clips the norm over all networks and takes one step of Adam. `squares` is the sum of the gradient's squares.
fn step(
    config: &PpoConfig,
    (actor, critics): (&mut Model, &mut [Model]),
    schedule: &mut Schedule,
    gradients: &mut Gradients,
    squares: f64,
    workers: &mut [Worker],
    totals: &mut UpdateStats,
) {
    let norm = squares.sqrt();
    if !norm.is_finite() {
        totals.skipped += 1;
        return;
    }
    totals.grad_norm += norm;
    totals.steps += 1;
    schedule.adam_step += 1;
    // As in PyTorch's clip_grad_norm_, including its small constant.
    let gradient_scale = (config.max_grad_norm / (norm + 1e-6)).min(1.0);
    let mut items = Vec::new();
    let models = core::iter::once(&mut *actor).chain(&mut *critics);
    for (model, gradient) in models.zip(gradients.networks_mut()) {
        let params = model.params.chunks_mut(RANGE);
        let moments = model.m.chunks_mut(RANGE).zip(model.v.chunks_mut(RANGE));
        for ((params, (m, v)), gradient) in params.zip(moments).zip(gradient.total.chunks(RANGE)) {
            items.push(AdamStep {
                params,
                m,
                v,
                gradient,
                gradient_scale,
                learning_rate: schedule.learning_rate,
                step: schedule.adam_step,
            });
        }
    }
    for_each(workers, items, |_, item| item.apply());
    let (lo, hi) = (config.min_std.ln() as f32, config.max_std.ln() as f32);
    for log_std in actor.log_std_mut() {
        *log_std = log_std.clamp(lo, hi);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rollout::RolloutLayout;

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
