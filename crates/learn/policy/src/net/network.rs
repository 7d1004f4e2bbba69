//! A stack of LSTM layers (possibly none) under a multilayer perceptron.

use paid_lanes::rng::Rng;

use super::{Layout, Linear, Lstm, Weights};
use crate::bf16::Scratch;
use crate::config::{NetworkConfig, NetworkKind};
use crate::element::Element;
use crate::matrix::{Mat, MatMut};

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
    /// Hidden state per layer.
    pub h: Vec<Vec<S>>,
    /// Cell state per layer.
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
    scratch: Scratch,
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

    /// One step: `x` `[input, n]` to `out` `[output, n]`; the state (of `n` environments) moves on.
    pub fn step<'w, S: Element>(
        &self,
        weights: impl Into<Weights<'w, S>>,
        x: Mat<'_, S>,
        state: &mut State<S>,
        mut out: MatMut<'_, S>,
        work: &mut StepWorkspace<S>,
    ) {
        let weights = weights.into();
        let n = x.cols();
        let mut first = 0;
        while first < n {
            let count = CHUNK.min(n - first);
            self.step_chunk(weights, x.columns(first, count), first, state, out.columns(first, count), work);
            first += count;
        }
    }

    fn step_chunk<S: Element>(
        &self,
        weights: Weights<'_, S>,
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
            let (h, c) = (h.columns(first, n), c.columns(first, n));
            layer.step(weights, input, h, c, &mut work.gates, &mut work.scratch);
        }
        let (mut source, mut target) = (&mut work.a, &mut work.b);
        for (k, layer) in self.mlp.iter().enumerate() {
            let input = match (k, state.h.last()) {
                (0, None) => x,
                (0, Some(h)) => Mat::new(h, layer.input, envs, envs).columns(first, n),
                _ => Mat::new(source, layer.input, n, n),
            };
            if k + 1 == self.mlp.len() {
                layer.forward(weights, input, out.reborrow(), &mut work.scratch);
            } else {
                let into = MatMut::new(target, layer.output, n, n);
                layer.forward(weights, input, into, &mut work.scratch);
                core::mem::swap(&mut source, &mut target);
            }
        }
    }
}
