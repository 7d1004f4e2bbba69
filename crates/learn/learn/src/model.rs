//! A network with its parameters and optimizer state.

use paid_lanes::rng::Rng;

use paid_policy::NetworkConfig;
use paid_policy::net::{Layout, Network};

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
