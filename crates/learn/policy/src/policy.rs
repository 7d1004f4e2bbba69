//! A trained policy: network, weights and normalizer, and how it acts.

use crate::matrix::{Mat, MatMut};
use crate::net::{Network, State, StepWorkspace};
use crate::normalizer::Normalizer;

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
    /// Recurrent state, `[size, n]` per layer; empty for a feed-forward policy.
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
