//! What a preset says about the shape of a network. Unknown keys are refused.

use serde::{Deserialize, Serialize};

/// Kind of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NetworkKind {
    /// Fully connected layers only.
    #[default]
    Mlp,
    /// LSTM layers under fully connected ones (the paper's policy).
    Lstm,
}

/// Activation behind every hidden layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Exponential linear unit, alpha 1.
    #[default]
    Elu,
}

/// LSTM layers; looked at only if the kind is `lstm`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LstmConfig {
    /// Number of layers.
    pub layers: usize,
    /// Cells per layer.
    pub size: usize,
}

impl Default for LstmConfig {
    /// One layer of 128: the release has two, which learn half as fast on a CPU.
    fn default() -> Self {
        Self { layers: 1, size: 128 }
    }
}

/// Shape of the actor or the critic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkConfig {
    /// With or without memory.
    pub kind: NetworkKind,
    /// Widths of the hidden fully connected layers.
    pub hidden: Vec<usize>,
    /// Recurrent layers.
    pub lstm: LstmConfig,
    /// Activation of the hidden layers.
    pub activation: Activation,
}

impl Default for NetworkConfig {
    /// MLP 256-128-64: half the release's widths, a quarter of its arithmetic, enough for the pilot's 13 clips.
    fn default() -> Self {
        Self {
            kind: NetworkKind::Mlp,
            hidden: vec![256, 128, 64],
            lstm: LstmConfig::default(),
            activation: Activation::Elu,
        }
    }
}
