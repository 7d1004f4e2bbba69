//! Writing a policy file.

use std::path::Path;

use prost::Message;

use paid_policy::Contract;
use paid_policy::contract::FORMAT;

use crate::error::OnnxError;
use crate::proto::{ModelProto, OperatorSetId, StringStringEntry};
use crate::reference::Reference;
use crate::released::released_metadata;
use crate::stored::Training;
use crate::weights::PolicyWeights;
use crate::{CONTRACT_KEY, IR_VERSION, OPSET, PRESET_KEY, RUN_KEY, STD_KEY, graph};

/// The bytes of an ONNX file. The same arguments give the same bytes. `run` is a plain name: it goes into the metadata as `run_path`,
/// a key of the released interface, and a path would reveal the machine. With `training` the file can be read back as a trained policy.
///
/// # Errors
/// [`OnnxError::Weights`] if weights, contract and reference do not fit together, or `run` has a path separator.
pub fn encode(
    weights: &PolicyWeights,
    contract: &Contract,
    reference: Option<&Reference>,
    run: &str,
    training: Option<&Training>,
) -> Result<Vec<u8>, OnnxError> {
    let (joints, bodies) = (contract.joints.len(), contract.bodies.len());
    if run.contains(['/', '\\']) {
        return Err(OnnxError::Weights(format!(
            "run name '{run}' has a path separator, expected a plain name"
        )));
    }
    weights.check().map_err(OnnxError::Weights)?;
    contract.check().map_err(OnnxError::Weights)?;
    if let Some(r) = reference {
        r.check(joints, bodies).map_err(OnnxError::Weights)?;
    }
    let state = contract.recurrent.map(|r| (r.layers, r.hidden));
    let own_state = weights.lstm.first().map(|l| (weights.lstm.len(), l.hidden));
    let mirrors = contract.play.as_ref().is_some_and(|play| play.mirror_left_kicks);
    for (what, expected, found) in [
        ("contract format", FORMAT.to_string(), contract.format.to_string()),
        ("observations", contract.observation_size().to_string(), weights.observations().to_string()),
        ("actions", joints.to_string(), weights.actions().to_string()),
        ("recurrent state", format!("{state:?}"), format!("{own_state:?}")),
        ("mirror", mirrors.to_string(), weights.mirror.is_some().to_string()),
        ("reference", format!("{:?}", contract.reference), format!("{:?}", reference.map(|r| &r.name))),
    ] {
        if expected != found {
            return Err(OnnxError::Weights(format!("{what}: expected {expected}, found {found}")));
        }
    }
    let mut metadata = released_metadata(contract);
    metadata.push((RUN_KEY, run.to_owned()));
    let fail = |e: serde_json::Error| OnnxError::Weights(e.to_string());
    metadata.push((CONTRACT_KEY, serde_json::to_string(contract).map_err(fail)?));
    if let Some(training) = training {
        metadata.push((PRESET_KEY, training.preset.clone()));
        metadata.push((STD_KEY, serde_json::to_string(&training.std).map_err(fail)?));
    }
    let model = ModelProto {
        ir_version: Some(IR_VERSION),
        producer_name: Some("paid".to_owned()),
        producer_version: Some(env!("CARGO_PKG_VERSION").to_owned()),
        graph: Some(graph::build(weights, reference, joints, bodies)),
        opset_import: vec![OperatorSetId { domain: Some(String::new()), version: Some(OPSET) }],
        metadata_props: metadata
            .into_iter()
            .map(|(key, value)| StringStringEntry { key: Some(key.to_owned()), value: Some(value) })
            .collect(),
    };
    Ok(model.encode_to_vec())
}

/// Writes a policy file; an earlier file stays whole on failure.
/// `run` is a plain name as in [`encode`].
///
/// # Errors
/// As [`encode`], and [`OnnxError::Io`].
pub fn write(
    path: &Path,
    weights: &PolicyWeights,
    contract: &Contract,
    reference: Option<&Reference>,
    run: &str,
    training: Option<&Training>,
) -> Result<(), OnnxError> {
    let bytes = encode(weights, contract, reference, run, training)?;
    paid_files::write_atomically(path, &bytes)
        .map_err(|source| OnnxError::Io { path: path.to_owned(), source })
}
