//! A stack of LSTM layers (possibly none) under a multilayer perceptron.

use core::ops::Range;

use paid_lanes::rng::Rng;

use super::{Layout, Linear, Lstm, LstmCache, Steps};
use crate::config::{NetworkConfig, NetworkKind};
use crate::element::Element;
use crate::matrix::{Mat, MatMut};

/// A loss on a chunk of outputs, see [`Network::train`].
pub type Loss<'a, S> = dyn FnMut(Range<usize>, Mat<'_, S>, MatMut<'_, S>) + 'a;

/// Columns that pass through all layers together: their activations stay in the second-level cache.
pub const CHUNK: usize = 256;

/// Shape of a network. Its parameters are a flat slice laid out by [`Network::layout`].
#[derive(Clone, Debug)]
pub struct Network {
    /// Features in.
    pub input: usize,
    /// Features out.
    pub output: usize,
    /// Recurrent layers, first to last.
    pub lstm: Vec<Lstm>,
    /// Fully connected layers, first to last; all but the last with ELU.
    pub mlp: Vec<Linear>,
    layout: Layout,
}

/// Recurrent state of `n` environments: `h` and `c` of each layer, `[size, n]`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct State<S> {
    /// Number of environments.
    pub n: usize,
    /// Hidden state a layer.
    pub h: Vec<Vec<S>>,
    /// Cell state a layer.
    pub c: Vec<Vec<S>>,
}

impl<S: Element> State<S> {
    /// Clears the state of environment `e`, whose episode ended.
    pub fn reset(&mut self, e: usize) {
        for layer in self.h.iter_mut().chain(&mut self.c) {
            for value in layer[e..].iter_mut().step_by(self.n) {
                *value = S::default();
            }
        }
    }
}

/// Scratch of [`Network::step`].
#[derive(Clone, Debug, Default)]
pub struct StepWorkspace<S> {
    gates: Vec<S>,
    a: Vec<S>,
    b: Vec<S>,
}

/// Scratch of [`Network::train`].
#[derive(Clone, Debug, Default)]
pub struct TrainWorkspace<S> {
    lstm: Vec<LstmCache<S>>,
    activations: Vec<Vec<S>>,
    gradients: [Vec<S>; 2],
    output_gradient: Vec<S>,
}

/// A piece of experience: `steps` steps of `width` environments in `steps * width` step-major columns.
#[derive(Clone, Copy, Debug)]
pub struct Sequence<'a, S> {
    /// `[input, steps * width]`.
    pub input: Mat<'a, S>,
    /// Steps, environments and where episodes began. A network without memory looks at none of it.
    pub steps: Steps<'a, S>,
    /// Recurrent state before the first step.
    pub state: &'a State<S>,
}

impl Network {
    /// The network that `config` describes.
    pub fn new(input: usize, output: usize, config: &NetworkConfig) -> Self {
        let mut layout = Layout::default();
        let mut width = input;
        let mut lstm = Vec::new();
        if config.kind == NetworkKind::Lstm {
            for layer in 0..config.lstm.layers {
                lstm.push(Lstm::new(&mut layout, &format!("lstm.{layer}"), width, config.lstm.size));
                width = config.lstm.size;
            }
        }
        let mut mlp = Vec::new();
        for (layer, &size) in config.hidden.iter().chain([&output]).enumerate() {
            let elu = layer < config.hidden.len();
            mlp.push(Linear::new(&mut layout, &format!("mlp.{layer}"), width, size, elu));
            width = size;
        }
        Self { input, output, lstm, mlp, layout }
    }

    /// Names, shapes and places of the parameters.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Fresh parameters.
    pub fn initialize<S: Element>(&self, rng: &mut Rng) -> Vec<S> {
        let mut params = vec![S::default(); self.layout.len()];
        for layer in &self.lstm {
            layer.initialize(&mut params, rng);
        }
        for layer in &self.mlp {
            layer.initialize(&mut params, rng);
        }
        params
    }

    /// True if it has memory.
    pub fn is_recurrent(&self) -> bool {
        !self.lstm.is_empty()
    }

    /// The state at the start of an episode for `n` environments.
    pub fn initial_state<S: Element>(&self, n: usize) -> State<S> {
        let zeros: Vec<Vec<S>> = self.lstm.iter().map(|layer| vec![S::default(); layer.size * n]).collect();
        State { n, h: zeros.clone(), c: zeros }
    }

    /// Floating-point operations of forward and backward for one sample (a multiply-add counts two).
    pub fn train_flop(&self) -> f64 {
        let mut weights = 0;
        let mut first = 0;
        for layer in &self.lstm {
            weights += 4 * layer.size * (layer.input + layer.size);
            first = if first == 0 { 4 * layer.size * layer.input } else { first };
        }
        for layer in &self.mlp {
            weights += layer.output * layer.input;
            first = if first == 0 { layer.output * layer.input } else { first };
        }
        // Forward, weight gradient and input gradient; the first layer needs no input gradient.
        (2 * (3 * weights - first)) as f64
    }

    /// One step: `x` `[input, n]` to `out` `[output, n]`; the state (of `n` environments) moves on.
    pub fn step<S: Element>(
        &self,
        params: &[S],
        x: Mat<'_, S>,
        state: &mut State<S>,
        mut out: MatMut<'_, S>,
        work: &mut StepWorkspace<S>,
    ) {
        let n = x.cols();
        let mut first = 0;
        while first < n {
            let count = CHUNK.min(n - first);
            self.step_chunk(params, x.columns(first, count), first, state, out.columns(first, count), work);
            first += count;
        }
    }

    fn step_chunk<S: Element>(
        &self,
        params: &[S],
        x: Mat<'_, S>,
        first: usize,
        state: &mut State<S>,
        mut out: MatMut<'_, S>,
        work: &mut StepWorkspace<S>,
    ) {
        let n = x.cols();
        let gates = self.lstm.iter().map(|layer| 4 * layer.size).max().unwrap_or(0);
        work.gates.resize(gates * n, S::default());
        let widest = self.mlp.iter().map(|layer| layer.output).max().unwrap_or(0);
        work.a.resize(widest * n, S::default());
        work.b.resize(widest * n, S::default());
        let envs = state.n;
        for (k, layer) in self.lstm.iter().enumerate() {
            let (below, here) = state.h.split_at_mut(k);
            let input = match below.last() {
                Some(h) => Mat::new(h, layer.input, envs, envs).columns(first, n),
                None => x,
            };
            let mut h = MatMut::new(&mut here[0], layer.size, envs, envs);
            let mut c = MatMut::new(&mut state.c[k], layer.size, envs, envs);
            layer.step(params, input, h.columns(first, n), c.columns(first, n), &mut work.gates);
        }
        let (mut source, mut target) = (&mut work.a, &mut work.b);
        for (k, layer) in self.mlp.iter().enumerate() {
            let input = match (k, state.h.last()) {
                (0, None) => x,
                (0, Some(h)) => Mat::new(h, layer.input, envs, envs).columns(first, n),
                _ => Mat::new(source, layer.input, n, n),
            };
            if k + 1 == self.mlp.len() {
                layer.forward(params, input, out.reborrow());
            } else {
                layer.forward(params, input, MatMut::new(target, layer.output, n, n));
                core::mem::swap(&mut source, &mut target);
            }
        }
    }

    /// Forward and backward over a sequence: adds the gradient of a loss to `grads`.
    ///
    /// `loss(columns, outputs, gradient)` gets the outputs `[output, columns.len()]` and writes the loss's gradient with
    /// respect to them. Columns come in chunks, in order, each once.
    pub fn train<S: Element>(
        &self,
        params: &[S],
        grads: &mut [S],
        sequence: Sequence<'_, S>,
        work: &mut TrainWorkspace<S>,
        loss: &mut Loss<'_, S>,
    ) {
        let Sequence { input, steps, state } = sequence;
        let cols = input.cols();
        let mut caches = core::mem::take(&mut work.lstm);
        caches.resize_with(self.lstm.len(), LstmCache::default);
        for (k, layer) in self.lstm.iter().enumerate() {
            let (below, here) = caches.split_at_mut(k);
            let x = below.last().map_or(input, LstmCache::output);
            layer.forward(params, x, steps, &state.h[k], &state.c[k], &mut here[0]);
        }
        let mut first = 0;
        while first < cols {
            let n = CHUNK.min(cols - first);
            match caches.last_mut() {
                Some(cache) => {
                    let (x, mut dx) = cache.output_and_gradient();
                    let (x, dx) = (x.columns(first, n), dx.columns(first, n));
                    self.train_mlp(params, grads, x, Some(dx), first, work, loss);
                }
                None => self.train_mlp(params, grads, input.columns(first, n), None, first, work, loss),
            }
            first += n;
        }
        for (k, layer) in self.lstm.iter().enumerate().rev() {
            let (below, here) = caches.split_at_mut(k);
            match below.last_mut() {
                Some(below) => {
                    let (x, dx) = below.output_and_gradient();
                    layer.backward(params, grads, x, steps, &mut here[0], Some(dx));
                }
                None => layer.backward(params, grads, input, steps, &mut here[0], None),
            }
        }
        work.lstm = caches;
    }

    #[allow(clippy::too_many_arguments)]
    fn train_mlp<S: Element>(
        &self,
        params: &[S],
        grads: &mut [S],
        x: Mat<'_, S>,
        mut dx: Option<MatMut<'_, S>>,
        first: usize,
        work: &mut TrainWorkspace<S>,
        loss: &mut Loss<'_, S>,
    ) {
        let n = x.cols();
        let TrainWorkspace { activations, gradients, output_gradient, .. } = work;
        activations.resize_with(self.mlp.len(), Vec::new);
        for (k, layer) in self.mlp.iter().enumerate() {
            let (below, here) = activations.split_at_mut(k);
            let input = below.last().map_or(x, |below| Mat::new(below, layer.input, n, n));
            here[0].resize(layer.output * n, S::default());
            layer.forward(params, input, MatMut::new(&mut here[0], layer.output, n, n));
        }
        let last = self.mlp.len() - 1;
        output_gradient.resize(self.output * n, S::default());
        let out = Mat::new(&activations[last], self.output, n, n);
        loss(first..first + n, out, MatMut::new(output_gradient, self.output, n, n));
        let widest = self.mlp.iter().map(|layer| layer.input).max().unwrap_or(0);
        for gradient in gradients.iter_mut() {
            gradient.resize(widest * n, S::default());
        }
        let [spare, other] = gradients;
        let (mut above, mut below) = (output_gradient, spare);
        let mut free = Some(other);
        for k in (0..=last).rev() {
            let layer = &self.mlp[k];
            let y = Mat::new(&activations[k], layer.output, n, n);
            let dy = MatMut::new(above, layer.output, n, n);
            if k == 0 {
                layer.backward(params, grads, x, y, dy, dx.take());
            } else {
                let input = Mat::new(&activations[k - 1], layer.input, n, n);
                let into = MatMut::new(below, layer.input, n, n);
                layer.backward(params, grads, input, y, dy, Some(into));
                // The output's gradient is not a scratch of full width: after the first layer only the two spares swap.
                let next = free.take().unwrap_or(above);
                above = below;
                below = next;
            }
        }
    }
}
