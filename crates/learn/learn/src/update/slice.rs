//! Gradients of a minibatch, slice by slice.

use paid_policy::Mirrors;
use paid_policy::net::State;

use super::mirrored::{self, Image};
use super::reduce::{Gradients, NetworkGradient};
use crate::config::PpoConfig;
use crate::gaussian::{ActorBatch, ActorLoss, ActorLossConfig, actor_loss};
use crate::model::Model;
use crate::net::{Sequence, Steps, TrainNetwork, TrainWorkspace};
use crate::operands::Operands;
use crate::parallel::for_each;
use crate::rollout::unit_ref;
use crate::shard::Shard;
use crate::stats::UpdateStats;
use crate::teacher::imitation_loss;
use crate::value_loss::{ValueBatch, value_loss};

/// Scratch of one thread.
#[derive(Clone, Debug, Default)]
pub struct Worker {
    pub(super) train: TrainWorkspace<f32>,
    dlog_prob: Vec<f32>,
    pub(super) image: Image,
    /// Scratch of collection.
    pub step: paid_policy::net::StepWorkspace<f32>,
}

/// Which network a slice trains, and where its loss goes.
enum Target<'a> {
    Actor(&'a mut ActorLoss, &'a mut Auxiliary),
    Critic(usize, &'a mut f64),
}

/// Sums of the losses beside the surrogate's.
#[derive(Clone, Copy, Debug, Default)]
struct Auxiliary {
    mirror: f64,
    teacher: f64,
}

/// One slice of a minibatch for one network.
struct Slice<'a> {
    target: Target<'a>,
    units: &'a [(usize, usize)],
    grads: &'a mut [f32],
}

/// What the slices of an update read.
pub(super) struct Shared<'a> {
    pub(super) config: &'a PpoConfig,
    pub(super) actor: &'a Model,
    pub(super) critics: &'a [Model],
    pub(super) operands: &'a Operands,
    pub(super) old_log_std: &'a [f32],
    pub(super) shards: &'a [Shard],
    pub(super) advantage: (f64, f64),
    /// How samples read in a mirrored world, and the number of the gradient step.
    pub(super) mirrors: Option<(&'a Mirrors, usize)>,
    /// Weight of the imitation loss; 0 without a teacher.
    pub(super) teacher: f64,
}

/// Gradients of this rank's units of one minibatch, one for each slice, and their share of its mean losses. `weight` is one over the
/// samples of the whole minibatch.
pub(super) fn minibatch_gradient(
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
    let mut auxiliary = vec![Auxiliary::default(); slices];
    let sinks = sums.iter_mut().zip(&mut auxiliary);
    for (s, (grads, (sums, auxiliary))) in gradients.actor.slices.iter_mut().zip(sinks).enumerate() {
        jobs.push(Slice { target: Target::Actor(sums, auxiliary), units: part(s), grads });
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
        losses.mirror_loss += auxiliary[s].mirror * weight;
        losses.teacher_loss += auxiliary[s].teacher * weight;
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
            Target::Actor(sums, auxiliary) => {
                let (loss, teacher) = train_actor(shared, weight, shard, unit, grads, worker);
                sums.surrogate += loss.surrogate;
                sums.kl += loss.kl;
                sums.clipped += loss.clipped;
                auxiliary.teacher += teacher;
                auxiliary.mirror += mirrored::train(shared, weight, shard, unit, grads, worker);
            }
            Target::Critic(critic, value) => {
                **value += train_critic(shared, *critic, weight, (shard, unit), grads, worker);
            }
        }
    }
}

/// The stored samples of a unit as input of a network.
pub(crate) fn sequence<'a>(
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

/// Surrogate's and imitation's loss of a unit, summed over its samples.
fn train_actor(
    shared: &Shared<'_>,
    weight: f64,
    shard: &Shard,
    unit: usize,
    grads: &mut [f32],
    worker: &mut Worker,
) -> (ActorLoss, f64) {
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
    let (mut total, mut apart) = (ActorLoss::default(), 0.0);
    let taught = (shared.teacher > 0.0).then(|| unit_ref(&r.taught, actions, place));
    let Worker { train, dlog_prob, .. } = worker;
    dlog_prob.resize(place.stride, 0.0);
    let sequence = sequence(shard, &r.policy_obs, rows, unit, &shard.actor_start);
    let weights = shared.operands.weights(0, shared.actor);
    net.train(weights, grads, sequence, train, &mut |columns, mean, mut dmean| {
        let samples = place.unit + columns.start..place.unit + columns.end;
        let batch = ActorBatch {
            action: unit_ref(&r.action, actions, place).columns(columns.start, columns.len()),
            old_mean: unit_ref(&r.mean, actions, place).columns(columns.start, columns.len()),
            old_log_std: shared.old_log_std,
            old_log_prob: &r.log_prob[samples.clone()],
            advantage: &r.advantage[samples],
        };
        let into = dmean.reborrow();
        let loss = actor_loss(config, mean, shared.actor.log_std(), batch, into, dlog_std, dlog_prob);
        total.surrogate += loss.surrogate;
        total.kl += loss.kl;
        total.clipped += loss.clipped;
        if let Some(taught) = taught {
            let wanted = taught.columns(columns.start, columns.len());
            apart += imitation_loss(weight * shared.teacher, shared.old_log_std, mean, wanted, &mut dmean);
        }
    });
    (total, apart)
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
