//! Training of a network: forward with caches, a loss, backward.

use core::ops::Range;

use paid_policy::bf16::Scratch;
use paid_policy::element::Element;
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::net::{CHUNK, Network, State, Weights};

use super::lstm::{LstmCache, Steps};
use super::{linear, lstm};

/// A loss on a chunk of outputs, see [`TrainNetwork::train`].
pub type Loss<'a, S> = dyn FnMut(Range<usize>, Mat<'_, S>, MatMut<'_, S>) + 'a;

/// Scratch of [`TrainNetwork::train`].
#[derive(Clone, Debug, Default)]
pub struct TrainWorkspace<S> {
    pub(super) lstm: Vec<LstmCache<S>>,
    /// What the first fully connected layer reads beside a memory.
    both: Vec<S>,
    activations: Vec<Vec<S>>,
    gradients: [Vec<S>; 2],
    output_gradient: Vec<S>,
    pub(super) scratch: Scratch,
}

/// A piece of experience: `steps` steps of `width` environments in `steps * width` step-major columns.
#[derive(Clone, Copy, Debug)]
pub struct Sequence<'a, S> {
    /// `[input, steps * width]`.
    pub input: Mat<'a, S>,
    /// Steps, environments and where episodes began. A feed-forward network uses none of it.
    pub steps: Steps<'a, S>,
    /// Recurrent state before the first step.
    pub state: &'a State<S>,
}

/// What a network can do while it is trained.
pub trait TrainNetwork {
    /// Floating-point operations of forward and backward for one sample (a multiply-add counts two).
    fn train_flop(&self) -> f64;

    /// Forward and backward over a sequence: adds the gradient of a loss to `grads`.
    ///
    /// `loss(columns, outputs, gradient)` gets the outputs `[output, columns.len()]` and writes the loss's gradient with
    /// respect to them. Columns come in chunks, in order, each once.
    fn train<'w, S: Element>(
        &self,
        weights: impl Into<Weights<'w, S>>,
        grads: &mut [S],
        sequence: Sequence<'_, S>,
        work: &mut TrainWorkspace<S>,
        loss: &mut Loss<'_, S>,
    );
}

impl TrainNetwork for Network {
    fn train_flop(&self) -> f64 {
        let (mut weights, mut fixed) = (0, 0);
        for layer in &self.lstm {
            weights += 4 * layer.size * (layer.input + layer.size);
            fixed += 4 * layer.size * self.fixed_inputs(&layer.weight_ih);
        }
        for layer in &self.mlp {
            weights += layer.output * layer.input;
            fixed += layer.output * self.fixed_inputs(&layer.weight);
        }
        // Forward, weight gradient and input gradient; the network's own input needs none.
        (2 * (3 * weights - fixed)) as f64
    }

    fn train<'w, S: Element>(
        &self,
        weights: impl Into<Weights<'w, S>>,
        grads: &mut [S],
        sequence: Sequence<'_, S>,
        work: &mut TrainWorkspace<S>,
        loss: &mut Loss<'_, S>,
    ) {
        let weights = weights.into();
        let Sequence { input, steps, state } = sequence;
        let cols = input.cols();
        let mut caches = core::mem::take(&mut work.lstm);
        caches.resize_with(self.lstm.len(), LstmCache::default);
        for (k, layer) in self.lstm.iter().enumerate() {
            let (below, here) = caches.split_at_mut(k);
            let x = below.last().map_or(self.remembered(input), LstmCache::output);
            let start = (&state.h[k][..], &state.c[k][..]);
            lstm::forward(layer, weights, x, steps, start, &mut here[0], &mut work.scratch);
        }
        let mut first = 0;
        while first < cols {
            let n = CHUNK.min(cols - first);
            match caches.last_mut() {
                Some(cache) => {
                    let (x, mut dx) = cache.output_and_gradient();
                    let (mut x, dx) = (x.columns(first, n), dx.columns(first, n));
                    let mut both = core::mem::take(&mut work.both);
                    if self.is_beside() {
                        x = self.beside(input.columns(first, n), x, &mut both);
                    }
                    train_mlp(self, weights, grads, x, Some(dx), first, work, loss);
                    work.both = both;
                }
                None => train_mlp(self, weights, grads, input.columns(first, n), None, first, work, loss),
            }
            first += n;
        }
        for (k, layer) in self.lstm.iter().enumerate().rev() {
            let (below, here) = caches.split_at_mut(k);
            match below.last_mut() {
                Some(below) => {
                    let (x, dx) = below.output_and_gradient();
                    lstm::backward(
                        layer,
                        weights,
                        grads,
                        x,
                        steps,
                        &mut here[0],
                        Some(dx),
                        &mut work.scratch,
                    );
                }
                None => {
                    let cache = &mut here[0];
                    let x = self.remembered(input);
                    lstm::backward(layer, weights, grads, x, steps, cache, None, &mut work.scratch);
                }
            }
        }
        work.lstm = caches;
    }
}

#[allow(clippy::too_many_arguments)]
fn train_mlp<S: Element>(
    net: &Network,
    weights: Weights<'_, S>,
    grads: &mut [S],
    x: Mat<'_, S>,
    mut dx: Option<MatMut<'_, S>>,
    first: usize,
    work: &mut TrainWorkspace<S>,
    loss: &mut Loss<'_, S>,
) {
    let n = x.cols();
    let TrainWorkspace { activations, gradients, output_gradient, scratch, .. } = work;
    activations.resize_with(net.mlp.len(), Vec::new);
    for (k, layer) in net.mlp.iter().enumerate() {
        let (below, here) = activations.split_at_mut(k);
        let input = below.last().map_or(x, |below| Mat::new(below, layer.input, n, n));
        here[0].resize(layer.output * n, S::default());
        layer.forward(weights, input, MatMut::new(&mut here[0], layer.output, n, n), scratch);
    }
    let last = net.mlp.len() - 1;
    output_gradient.resize(net.output * n, S::default());
    let out = Mat::new(&activations[last], net.output, n, n);
    loss(first..first + n, out, MatMut::new(output_gradient, net.output, n, n));
    let widest = net.mlp.iter().map(|layer| layer.input).max().unwrap_or(0);
    for gradient in gradients.iter_mut() {
        gradient.resize(widest * n, S::default());
    }
    let [spare, other] = gradients;
    let (mut above, mut below) = (output_gradient, spare);
    let mut free = Some(other);
    for k in (0..=last).rev() {
        let layer = &net.mlp[k];
        let y = Mat::new(&activations[k], layer.output, n, n);
        let dy = MatMut::new(above, layer.output, n, n);
        if k == 0 {
            linear::backward(layer, weights, grads, [x, y], dy, dx.take(), scratch);
        } else {
            let input = Mat::new(&activations[k - 1], layer.input, n, n);
            let into = MatMut::new(below, layer.input, n, n);
            linear::backward(layer, weights, grads, [input, y], dy, Some(into), scratch);
            // The output's gradient is not a scratch of full width: after the first layer only the two spares swap.
            let next = free.take().unwrap_or(above);
            above = below;
            below = next;
        }
    }
}
