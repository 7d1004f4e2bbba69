//! Sums gradients over slices and ranks, and steps.

use paid_policy::element::Element;

use super::{Schedule, Worker};
use crate::adam::{AdamStep, Reduce};
use crate::config::PpoConfig;
use crate::model::Model;
use crate::parallel::for_each;
use crate::ranks::Ranks;
use crate::stats::UpdateStats;

/// Parameters that one thread reduces or steps at a time.
const RANGE: usize = 16 * 1024;

/// Gradients of the slices and their sums; kept so that updates need not allocate them.
#[derive(Clone, Debug, Default)]
pub struct Gradients {
    pub(super) actor: NetworkGradient,
    pub(super) critics: Vec<NetworkGradient>,
    /// What ranks exchange.
    flat: Vec<f32>,
}

/// Gradient of one network.
#[derive(Clone, Debug, Default)]
pub(super) struct NetworkGradient {
    /// One per slice.
    pub(super) slices: Vec<Vec<f32>>,
    /// Their sum.
    total: Vec<f32>,
}

impl Gradients {
    /// The actor's, then the critics'.
    pub(super) fn networks_mut(&mut self) -> impl Iterator<Item = &mut NetworkGradient> {
        core::iter::once(&mut self.actor).chain(&mut self.critics)
    }
}

/// Sums the slices of every network; the sum of the squares over all of them.
pub(super) fn sum_slices(
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
pub(super) fn sum_ranks(
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
pub(super) fn step(
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
