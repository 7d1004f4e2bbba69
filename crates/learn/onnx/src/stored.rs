//! The policy that a file of this program stores, from its constants alone: no runtime, and the same numbers as in training.

use paid_policy::net::Network;
use paid_policy::normalizer::Normalizer;
use paid_policy::{Contract, LstmConfig, NetworkConfig, NetworkKind, Policy};

use crate::error::OnnxError;
use crate::graph::gates_ifco;
use crate::proto::{GraphProto, TensorProto};
use crate::raw::OnnxFile;
use crate::read::{check_opset, check_tensors};
use crate::weights::{DenseLayer, LstmLayer, NormalizerWeights, PolicyWeights};
use crate::{PRESET_KEY, RUN_KEY, STD_KEY};

/// What a policy was trained with, by its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Training {
    /// The run's resolved preset, as TOML.
    pub preset: String,
    /// Standard deviation of each action at the end of training.
    pub std: Vec<f32>,
}

/// A policy with everything that its file says.
#[derive(Clone, Debug)]
pub struct StoredPolicy {
    /// The file's self-description.
    pub contract: Contract,
    /// The run's resolved preset, as TOML.
    pub preset: String,
    /// The name of the run.
    pub run: String,
    /// Network and normalizer.
    pub policy: Policy,
}

impl OnnxFile {
    /// The policy that the file stores with its preset; `None` for a file without a preset, which says too little of its task.
    ///
    /// # Errors
    /// If the metadata are damaged, or a constant is missing or of another size.
    pub fn stored(&self) -> Result<Option<StoredPolicy>, OnnxError> {
        let Some(preset) = self.metadata(PRESET_KEY) else { return Ok(None) };
        let path = &self.path;
        check_opset(&self.proto, path)?;
        let contract = self.contract()?;
        let graph = self.proto.graph.as_ref();
        let graph =
            graph.ok_or_else(|| OnnxError::Graph { path: path.clone(), reason: "none".to_owned() })?;
        check_tensors(graph, path)?;
        let std = self.metadata(STD_KEY).unwrap_or_default();
        let std: Vec<f32> = serde_json::from_str(std).map_err(|error| OnnxError::Metadata {
            path: path.clone(),
            key: STD_KEY.to_owned(),
            reason: error.to_string(),
        })?;
        let wrong = |reason: String| OnnxError::Graph { path: path.clone(), reason };
        let weights = Constants(graph).weights().map_err(wrong)?;
        weights.check().map_err(wrong)?;
        let memory = weights.lstm.first().map(|layer| (weights.lstm.len(), layer.hidden));
        let found = (weights.observations(), weights.actions(), std.len(), memory);
        let joints = contract.joints.len();
        let memory = contract.recurrent.map(|r| (r.layers, r.hidden));
        let expected = (contract.observation_size(), joints, joints, memory);
        if found != expected {
            return Err(wrong(format!(
                "observations, actions, deviations, memory: expected {expected:?}, found {found:?}"
            )));
        }
        let policy = policy(weights, std).map_err(wrong)?;
        let (preset, run) = (preset.to_owned(), self.metadata(RUN_KEY).unwrap_or_default().to_owned());
        Ok(Some(StoredPolicy { contract, preset, run, policy }))
    }
}

/// The network that has these numbers.
fn policy(weights: PolicyWeights, std: Vec<f32>) -> Result<Policy, String> {
    let (observations, actions) = (weights.observations(), weights.actions());
    let mut hidden: Vec<usize> = weights.layers.iter().map(|layer| layer.outputs).collect();
    hidden.pop();
    let mut config = NetworkConfig { hidden, ..NetworkConfig::default() };
    if let Some(first) = weights.lstm.first() {
        let beside = weights.is_beside();
        config.kind = if beside { NetworkKind::Memory } else { NetworkKind::Lstm };
        let inputs = if beside { first.inputs } else { 0 };
        config.lstm = LstmConfig { layers: weights.lstm.len(), size: first.hidden, inputs };
    }
    config.check().map_err(|error| error.to_string())?;
    let net = Network::new(observations, actions, &config);
    let mut params = vec![0.0; net.layout().len()];
    let mut put = |range: &core::ops::Range<usize>, values: &[f32]| {
        params[range.clone()].copy_from_slice(values);
    };
    for (to, from) in net.lstm.iter().zip(&weights.lstm) {
        put(&to.weight_ih, &from.w_input);
        put(&to.weight_hh, &from.w_hidden);
        put(&to.bias, &from.bias);
    }
    for (to, from) in net.mlp.iter().zip(&weights.layers) {
        put(&to.weight, &from.w);
        put(&to.bias, &from.b);
    }
    let normalizer = match weights.normalizer {
        Some(NormalizerWeights { mean, scale, clip: None }) => Normalizer::frozen(mean, scale),
        _ => return Err("expected a normalizer without a clip".to_owned()),
    };
    Ok(Policy { net, params, normalizer, std })
}

/// The named constants of a graph that [`crate::encode`] has written.
struct Constants<'a>(&'a GraphProto);

impl Constants<'_> {
    fn weights(&self) -> Result<PolicyWeights, String> {
        let normalizer = NormalizerWeights {
            mean: self.floats("normalizer.mean")?.1,
            scale: self.floats("normalizer.scale")?.1,
            clip: None,
        };
        let lstm = (0..).take_while(|i| self.find(&format!("lstm.{i}.W")).is_some());
        let layers = (0..).take_while(|i| self.find(&format!("actor.{i}.weight")).is_some());
        Ok(PolicyWeights {
            normalizer: Some(normalizer),
            lstm: lstm.map(|i| self.lstm_layer(i)).collect::<Result<_, _>>()?,
            layers: layers.map(|i| self.dense_layer(i)).collect::<Result<_, _>>()?,
            mirror: None,
        })
    }

    fn dense_layer(&self, i: usize) -> Result<DenseLayer, String> {
        let name = format!("actor.{i}.weight");
        match self.floats(&name)? {
            (shape, w) if shape.len() == 2 => {
                let b = self.floats(&format!("actor.{i}.bias"))?.1;
                Ok(DenseLayer { inputs: shape[1], outputs: shape[0], w, b })
            }
            (shape, _) => Err(format!("constant '{name}': expected a matrix, found {shape:?}")),
        }
    }

    fn lstm_layer(&self, i: usize) -> Result<LstmLayer, String> {
        let [w, r, b] = ["W", "R", "B"].map(|part| self.floats(&format!("lstm.{i}.{part}")));
        let ((shape, w), (_, r), (_, b)) = (w?, r?, b?);
        let (hidden, inputs) = match shape[..] {
            [1, rows, inputs] => (rows / 4, inputs),
            _ => {
                return Err(format!(
                    "constant 'lstm.{i}.W': expected [1, 4 * hidden, inputs], found {shape:?}"
                ));
            }
        };
        let sizes = (w.len(), r.len(), b.len());
        let expected = (4 * hidden * inputs, 4 * hidden * hidden, 8 * hidden);
        if sizes != expected {
            return Err(format!("LSTM layer {i}: expected {expected:?} numbers, found {sizes:?}"));
        }
        Ok(LstmLayer {
            inputs,
            hidden,
            w_input: gates_ifco(&w, hidden, inputs),
            w_hidden: gates_ifco(&r, hidden, hidden),
            bias: gates_ifco(&b[..4 * hidden], hidden, 1),
        })
    }

    fn find(&self, name: &str) -> Option<&TensorProto> {
        self.0.initializer.iter().find(|tensor| tensor.name.as_deref() == Some(name))
    }

    /// Shape and numbers of a constant, whose sizes have been checked.
    fn floats(&self, name: &str) -> Result<(Vec<usize>, Vec<f32>), String> {
        let tensor = self.find(name).ok_or_else(|| format!("expected a constant '{name}', found none"))?;
        let (words, _) = tensor.raw_data.as_deref().unwrap_or_default().as_chunks::<4>();
        let shape = tensor.dims.iter().map(|&size| usize::try_from(size).unwrap_or_default()).collect();
        Ok((shape, words.iter().map(|word| f32::from_le_bytes(*word)).collect()))
    }
}
