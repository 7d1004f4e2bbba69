//! A stack of LSTM layers (possibly none) under a multilayer perceptron, or beside its input.

use core::ops::Range;

use paid_lanes::rng::Rng;

use super::{Layout, Linear, Lstm, Weights};
use crate::bf16::Scratch;
use crate::config::{LstmConfig, NetworkConfig, NetworkKind};
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
    /// Recurrent layers, first to last. The first reads the last features of the input, as many as its own.
    pub lstm: Vec<Lstm>,
    /// Fully connected layers, first to last; all but the last with ELU.
    pub mlp: Vec<Linear>,
    /// Features of the input that the first fully connected layer reads in front of the memory's output: all of them without a
    /// memory or beside one ([`NetworkKind::Memory`]), none above one.
    pub direct: usize,
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
    /// Input and memory's output, one above the other.
    both: Vec<S>,
    scratch: Scratch,
}

impl Network {
    /// The network that `config` describes.
    pub fn new(input: usize, output: usize, config: &NetworkConfig) -> Self {
        let mut layout = Layout::default();
        let LstmConfig { layers, size, inputs } = config.lstm;
        let beside = config.kind == NetworkKind::Memory;
        let mut width = if beside && inputs > 0 { inputs.min(input) } else { input };
        let mut lstm = Vec::new();
        for layer in 0..if config.is_recurrent() { layers } else { 0 } {
            lstm.push(Lstm::new(&mut layout, &format!("lstm.{layer}"), width, size));
            width = size;
        }
        let direct = if config.kind == NetworkKind::Lstm { 0 } else { input };
        let mut mlp = Vec::new();
        width = direct + lstm.last().map_or(0, |layer: &Lstm| layer.size);
        for (layer, &size) in config.hidden.iter().chain([&output]).enumerate() {
            let elu = layer < config.hidden.len();
            mlp.push(Linear::new(&mut layout, &format!("mlp.{layer}"), width, size, elu));
            width = size;
        }
        Self { input, output, lstm, mlp, direct, layout }
    }

    /// Names, shapes and places of the parameters.
    pub fn layout(&self) -> &Layout {
        &self.layout
    }

    /// Fresh parameters. A memory beside the input weighs nothing at first: the network begins as the one without it would.
    pub fn initialize<S: Element>(&self, rng: &mut Rng) -> Vec<S> {
        let mut params = vec![S::default(); self.layout.len()];
        let beside = self.is_beside();
        if !beside {
            self.lstm.iter().for_each(|layer| layer.initialize(&mut params, rng));
        }
        for (k, layer) in self.mlp.iter().enumerate() {
            let known = if beside && k == 0 { self.direct } else { layer.input };
            layer.initialize_first(known, &mut params, rng);
        }
        if beside {
            for layer in &self.lstm {
                layer.initialize(&mut params, rng);
                layer.initialize_spans(&mut params, rng);
            }
        }
        params
    }

    /// True if it has a memory beside its input.
    pub fn is_beside(&self) -> bool {
        self.is_recurrent() && self.direct > 0
    }

    /// The features of the input that the first recurrent layer reads.
    pub fn remembered_features(&self) -> Range<usize> {
        self.input - self.lstm.first().map_or(0, |layer| layer.input)..self.input
    }

    /// The rows of an input `[input, n]` that the first recurrent layer reads.
    pub fn remembered<'a, S: Element>(&self, x: Mat<'a, S>) -> Mat<'a, S> {
        let rows = self.remembered_features();
        x.rows_from(rows.start, rows.len())
    }

    /// The first inputs of the weight matrix at a place whose gradient is not needed, because they are the network's own.
    pub fn fixed_inputs(&self, weight: &Range<usize>) -> usize {
        let first = self.lstm.first().filter(|layer| layer.weight_ih == *weight).map(|layer| layer.input);
        first.unwrap_or_else(|| if self.mlp[0].weight == *weight { self.direct } else { 0 })
    }

    /// What the first fully connected layer reads beside a memory: `x` `[input, n]` above `h` `[size, n]`, in `room`.
    pub fn beside<'a, S: Element>(&self, x: Mat<'_, S>, h: Mat<'_, S>, room: &'a mut Vec<S>) -> Mat<'a, S> {
        let (n, rows) = (x.cols(), x.rows() + h.rows());
        room.resize(rows * n, S::default());
        let sources = (0..x.rows()).map(|r| x.row(r)).chain((0..h.rows()).map(|r| h.row(r)));
        for (row, source) in room.chunks_exact_mut(n.max(1)).zip(sources) {
            row.copy_from_slice(source);
        }
        Mat::new(room, rows, n, n)
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
                None => self.remembered(x),
            };
            let mut h = MatMut::new(&mut here[0], layer.size, envs, envs);
            let mut c = MatMut::new(&mut state.c[k], layer.size, envs, envs);
            let (h, c) = (h.columns(first, n), c.columns(first, n));
            layer.step(weights, input, h, c, &mut work.gates, &mut work.scratch);
        }
        let seen = match state.h.last() {
            None => x,
            Some(h) => {
                let h = Mat::new(h, h.len() / envs.max(1), envs, envs).columns(first, n);
                if self.is_beside() { self.beside(x, h, &mut work.both) } else { h }
            }
        };
        let (mut source, mut target) = (&mut work.a, &mut work.b);
        for (k, layer) in self.mlp.iter().enumerate() {
            let input = if k == 0 { seen } else { Mat::new(source, layer.input, n, n) };
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
