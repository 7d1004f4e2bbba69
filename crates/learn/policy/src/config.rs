//! A preset's values for the shape of a network. Unknown keys are refused.

use serde::{Deserialize, Serialize};

/// Widths, inputs and outputs of a network at most: far more than any policy needs, and few enough that sums of sizes cannot overflow.
pub const MOST_WIDTH: usize = 65_536;
/// Hidden layers of a network at most, and recurrent ones.
pub const MOST_LAYERS: usize = 64;

/// Kind of a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum NetworkKind {
    /// Fully connected layers only.
    #[default]
    Mlp,
    /// LSTM layers under fully connected ones (the paper's policy).
    Lstm,
    /// Fully connected layers, the first of which reads the output of LSTM layers beside the whole observation.
    Memory,
}

/// Activation behind every hidden layer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Activation {
    /// Exponential linear unit, alpha 1.
    #[default]
    Elu,
}

/// LSTM layers; used only if the kind is `lstm` or `memory`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LstmConfig {
    /// Number of layers.
    pub layers: usize,
    /// Cells per layer.
    pub size: usize,
    /// Features at the end of the observation that the LSTM of a `memory` reads; 0 is all of them, as those of an `lstm` always are.
    #[serde(default)]
    pub inputs: usize,
}

impl Default for LstmConfig {
    /// One layer of 128: the release has two, which learn half as fast on a CPU.
    fn default() -> Self {
        Self { layers: 1, size: 128, inputs: 0 }
    }
}

/// Shape of the actor or the critic.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NetworkConfig {
    /// Feed-forward, recurrent, or both side by side.
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

/// A size that no network has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{key}: expected {expected}, found {found}")]
pub struct SizeError {
    /// The key within the network's section.
    pub key: &'static str,
    /// What it may be.
    pub expected: &'static str,
    /// What it is.
    pub found: String,
}

impl NetworkConfig {
    /// Checks the sizes, before anything is made by them.
    ///
    /// # Errors
    /// The first one out of range.
    pub fn check(&self) -> Result<(), SizeError> {
        let widths = 1..=MOST_WIDTH;
        if self.hidden.len() > MOST_LAYERS {
            let found = format!("{} of them", self.hidden.len());
            return Err(SizeError { key: "hidden", expected: "at most 64 widths", found });
        }
        if !self.hidden.iter().all(|width| widths.contains(width)) {
            let found = format!("{:?}", self.hidden);
            return Err(SizeError { key: "hidden", expected: "widths of 1 to 65536", found });
        }
        let LstmConfig { layers, size, inputs } = self.lstm;
        let cells = (1..=MOST_LAYERS).contains(&layers) && widths.contains(&size);
        if self.is_recurrent() && !cells {
            let expected = "1 to 64 layers of 1 to 65536 cells";
            return Err(SizeError { key: "lstm", expected, found: format!("{layers} x {size}") });
        }
        if self.kind == NetworkKind::Lstm && inputs > 0 {
            let expected = "0 for the kind lstm, which reads all";
            return Err(SizeError { key: "lstm.inputs", expected, found: inputs.to_string() });
        }
        Ok(())
    }

    /// [`NetworkConfig::check`], for an observation of `features` numbers.
    ///
    /// # Errors
    /// The first size out of range.
    pub fn check_for(&self, features: usize) -> Result<(), SizeError> {
        self.check()?;
        if self.kind == NetworkKind::Memory && self.lstm.inputs > features {
            let found = format!("{} of {features}", self.lstm.inputs);
            return Err(SizeError { key: "lstm.inputs", expected: "no more than are observed", found });
        }
        Ok(())
    }

    /// True if it has memory.
    pub fn is_recurrent(&self) -> bool {
        self.kind != NetworkKind::Mlp
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_no_network_has_are_refused() {
        let of = |kind, hidden: &[usize], layers, size| {
            let lstm = LstmConfig { layers, size, inputs: 0 };
            NetworkConfig { kind, hidden: hidden.to_vec(), lstm, ..NetworkConfig::default() }.check()
        };
        let (mlp, lstm, memory) = (NetworkKind::Mlp, NetworkKind::Lstm, NetworkKind::Memory);
        assert_eq!(of(lstm, &[MOST_WIDTH; MOST_LAYERS], MOST_LAYERS, MOST_WIDTH), Ok(()));
        assert_eq!(of(mlp, &[], 0, 0), Ok(()), "it has no memory");
        for (kind, hidden, layers, size, text) in [
            (mlp, &[8, 0][..], 1, 8, "hidden: expected widths of 1 to 65536, found [8, 0]"),
            (mlp, &[65_537], 1, 8, "hidden: expected widths of 1 to 65536, found [65537]"),
            (mlp, &[8; 65], 1, 8, "hidden: expected at most 64 widths, found 65 of them"),
            (lstm, &[8], 0, 8, "lstm: expected 1 to 64 layers of 1 to 65536 cells, found 0 x 8"),
            (memory, &[8], 0, 8, "lstm: expected 1 to 64 layers of 1 to 65536 cells, found 0 x 8"),
            (lstm, &[8], 65, 8, "lstm: expected 1 to 64 layers of 1 to 65536 cells, found 65 x 8"),
            (lstm, &[8], 1, 65_537, "lstm: expected 1 to 64 layers of 1 to 65536 cells, found 1 x 65537"),
        ] {
            assert_eq!(of(kind, hidden, layers, size).expect_err(text).to_string(), text);
        }
    }

    #[test]
    fn a_memory_reads_no_more_than_there_is() {
        let lstm = LstmConfig { inputs: 5, ..LstmConfig::default() };
        let mut config = NetworkConfig { kind: NetworkKind::Memory, lstm, ..NetworkConfig::default() };
        assert_eq!((config.check(), config.check_for(5)), (Ok(()), Ok(())));
        let text = config.check_for(4).expect_err("too many").to_string();
        assert_eq!(text, "lstm.inputs: expected no more than are observed, found 5 of 4");
        config.kind = NetworkKind::Lstm;
        let text = config.check().expect_err("it reads all").to_string();
        assert_eq!(text, "lstm.inputs: expected 0 for the kind lstm, which reads all, found 5");
    }
}
