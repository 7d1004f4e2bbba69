//! The mirror symmetry loss: in the mirror image of a state the policy should do the mirrored action.

use paid_policy::Mirror;
use paid_policy::matrix::{Mat, MatMut};

use super::slice::{Shared, Worker, sequence};
use crate::net::{Sequence, TrainNetwork};
use crate::rollout::unit_ref;
use crate::shard::Shard;
use crate::teacher::squared_distance;

/// Room for the mirror image of a unit.
#[derive(Clone, Debug, Default)]
pub(super) struct Image {
    observation: Vec<f32>,
    mean: Vec<f32>,
}

/// `[rows, n]` in a vector that is long enough.
fn mirrored<'a>(mirror: &Mirror, x: Mat<'_, f32>, room: &'a mut Vec<f32>) -> Mat<'a, f32> {
    let (rows, n) = (x.rows(), x.cols());
    room.resize(rows * n, 0.0);
    mirror.apply(x, MatMut::new(room, rows, n, n));
    Mat::new(room, rows, n, n)
}

/// Adds the gradient of a unit's loss to the actor's, if it is the unit's turn in this gradient step; returns the sum over its samples,
/// times the number of units of which this one was taken. `weight` is one over the samples of the minibatch.
pub(super) fn train(
    shared: &Shared<'_>,
    weight: f64,
    shard: &Shard,
    unit: usize,
    grads: &mut [f32],
    worker: &mut Worker,
) -> f64 {
    let Some((mirrors, step)) = shared.mirrors else { return 0.0 };
    let every = shared.config.mirror.every();
    if !(unit + step).is_multiple_of(every) {
        return 0.0;
    }
    let r = &shard.rollout;
    let [rows, _, actions] = r.dims;
    let (_, place) = r.layout.unit(unit);
    let net = &shared.actor.net;
    let (grads, _) = grads.split_at_mut(net.layout().len());
    let Worker { train, image, .. } = worker;
    let wanted = mirrored(&mirrors.action, unit_ref(&r.mean, actions, place), &mut image.mean);
    let seen = sequence(shard, &r.policy_obs, rows, unit, &shard.actor_start);
    let seen = Sequence { input: mirrored(&mirrors.observation, seen.input, &mut image.observation), ..seen };
    // An image's deviations are those of the other side's joints.
    let inv_variance: Vec<f32> =
        mirrors.action.signs().map(|(from, _)| (-2.0 * shared.old_log_std[from]).exp()).collect();
    let scale = (2.0 * weight * shared.config.mirror.weight * every as f64) as f32;
    let mut total = 0.0;
    let weights = shared.operands.weights(0, shared.actor);
    net.train(weights, grads, seen, train, &mut |columns, mean, mut dmean| {
        (0..mean.rows()).for_each(|a| dmean.row(a).fill(0.0));
        let wanted = wanted.columns(columns.start, columns.len());
        total += squared_distance(scale, inv_variance.iter().copied(), mean, wanted, &mut dmean);
    });
    total * every as f64
}
