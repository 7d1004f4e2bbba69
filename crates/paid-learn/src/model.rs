//! A network with its parameters and optimizer state, and the policy that a trained one makes.

use paid_lanes::rng::Rng;

use crate::config::NetworkConfig;
use crate::matrix::{Mat, MatMut};
use crate::net::{Layout, Network, State, StepWorkspace};
use crate::normalizer::Normalizer;

/// Name of the tensor of log standard deviations.
pub const LOG_STD: &str = "log_std";

/// Network, parameters and Adam's moments, all of one layout.
#[derive(Clone, Debug)]
pub struct Model {
    /// Shape.
    pub net: Network,
    /// Tensors of the parameter vector: the network's, then (actor only) `log_std` `[actions]`.
    pub layout: Layout,
    /// Parameters.
    pub params: Vec<f32>,
    /// Adam's first moment.
    pub m: Vec<f32>,
    /// Adam's second moment.
    pub v: Vec<f32>,
}

impl Model {
    /// A fresh network; with `initial_std` it is an actor and has `log_std` behind its weights.
    pub fn new(
        input: usize,
        output: usize,
        config: &NetworkConfig,
        initial_std: Option<f64>,
        rng: &mut Rng,
    ) -> Self {
        let net = Network::new(input, output, config);
        let mut layout = net.layout().clone();
        let mut params = net.initialize(rng);
        if let Some(std) = initial_std {
            layout.add(LOG_STD, &[output]);
            params.resize(layout.len(), std.ln() as f32);
        }
        let zeros = vec![0.0; layout.len()];
        Self { net, layout, params, m: zeros.clone(), v: zeros }
    }

    /// Logarithm of the actions' standard deviations; empty for a critic.
    pub fn log_std(&self) -> &[f32] {
        &self.params[self.net.layout().len()..]
    }

    /// The same, writable.
    pub fn log_std_mut(&mut self) -> &mut [f32] {
        let weights = self.net.layout().len();
        &mut self.params[weights..]
    }

    /// Weights and biases.
    pub fn weights(&self) -> &[f32] {
        &self.params[..self.net.layout().len()]
    }

    /// A tensor of the parameters by name.
    pub fn tensor(&self, name: &str) -> Option<&[f32]> {
        self.layout.find(name).map(|spec| &self.params[spec.range.clone()])
    }
}

/// What evaluation and export need of a trained actor.
#[derive(Clone, Debug)]
pub struct Policy {
    /// Shape.
    pub net: Network,
    /// Weights, laid out by `net.layout()`.
    pub params: Vec<f32>,
    /// Normalization of the observation.
    pub normalizer: Normalizer,
    /// Standard deviation of each action in training.
    pub std: Vec<f32>,
}

/// Recurrent state and scratch of a policy that acts on a batch.
#[derive(Clone, Debug, Default)]
pub struct PolicyState {
    /// Recurrent state, `[size, n]` a layer; empty without memory.
    pub recurrent: State<f32>,
    normalized: Vec<f32>,
    work: StepWorkspace<f32>,
}

impl PolicyState {
    /// Clears the memory of environment `e`, whose episode ended.
    pub fn reset(&mut self, e: usize) {
        self.recurrent.reset(e);
    }
}

impl Policy {
    /// Features of the observation.
    pub fn obs_dim(&self) -> usize {
        self.net.input
    }

    /// Number of actions.
    pub fn action_dim(&self) -> usize {
        self.net.output
    }

    /// The state at the start of an episode for `n` environments.
    pub fn start(&self, n: usize) -> PolicyState {
        PolicyState { recurrent: self.net.initial_state(n), ..PolicyState::default() }
    }

    /// The mean action: raw `obs` `[obs_dim, n]` to `actions` `[action_dim, n]`; `state` (from [`Policy::start`] with the
    /// same `n`) moves on.
    ///
    /// # Panics
    /// If the slices do not fit `n`.
    pub fn act(&self, obs: &[f32], state: &mut PolicyState, actions: &mut [f32]) {
        let n = state.recurrent.n;
        assert!(obs.len() == self.net.input * n, "observations must be [{}, {n}]", self.net.input);
        assert!(actions.len() == self.net.output * n, "actions must be [{}, {n}]", self.net.output);
        state.normalized.resize(obs.len(), 0.0);
        let rows = self.net.input;
        let out = MatMut::new(&mut state.normalized, rows, n, n);
        self.normalizer.apply(Mat::new(obs, rows, n, n), out, None);
        let x = Mat::new(&state.normalized, rows, n, n);
        let out = MatMut::new(actions, self.net.output, n, n);
        self.net.step(&self.params, x, &mut state.recurrent, out, &mut state.work);
    }
}
