//! Reading a policy file and running it.

use std::path::Path;

use paid_policy::Contract;
use paid_policy::contract::FORMAT;

use crate::error::OnnxError;
use crate::graph::MIRROR;
use crate::proto::{FLOAT, GraphProto, INT64, ModelProto, ValueInfo};
use crate::raw::{OnnxFile, RawModel};
use crate::reference::Reference;
use crate::released::released_metadata;
use crate::{CONTRACT_KEY, OPSET, RELEASED_KEYS};

/// A policy that was read from a file, ready to act for one robot at a time.
#[derive(Debug)]
pub struct OnnxPolicy {
    raw: RawModel,
    contract: Contract,
}

/// Recurrent state of one robot; empty for a feed-forward policy. Reset it whenever the policy starts again.
#[derive(Clone, Debug, PartialEq)]
pub struct OnnxState {
    /// Hidden state `[layers, hidden]`.
    pub h: Vec<f32>,
    /// Cell state `[layers, hidden]`.
    pub c: Vec<f32>,
}

impl OnnxState {
    /// Back to zero.
    pub fn reset(&mut self) {
        self.h.fill(0.0);
        self.c.fill(0.0);
    }
}

impl OnnxPolicy {
    /// Reads a file and checks it against its own contract.
    ///
    /// # Errors
    /// One [`OnnxError`] for the first thing that is wrong: unreadable, truncated, another operator set, metadata missing or
    /// contradicting the contract, sizes that differ from the contract, a graph that does not run.
    pub fn load(path: &Path) -> Result<Self, OnnxError> {
        Self::from_file(OnnxFile::read(path)?)
    }

    /// Reads a file and requires its contract to be `expected`.
    ///
    /// # Errors
    /// As [`Self::load`]; [`OnnxError::ContractDiffers`] with every difference.
    pub fn load_expecting(path: &Path, expected: &Contract) -> Result<Self, OnnxError> {
        let policy = Self::load(path)?;
        let differences = expected.differences(&policy.contract);
        if differences.is_empty() {
            Ok(policy)
        } else {
            Err(OnnxError::ContractDiffers { path: path.to_owned(), differences })
        }
    }

    /// As [`Self::load`], from the file's bytes; `path` only names them in errors.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, OnnxError> {
        Self::from_file(OnnxFile::from_bytes(bytes.to_vec(), path)?)
    }

    /// As [`Self::load`], from a file that was read.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub fn from_file(file: OnnxFile) -> Result<Self, OnnxError> {
        let (model, path) = (&file.proto, &file.path);
        check_opset(model, path)?;
        let contract = file.contract()?;
        if let Some(graph) = &model.graph {
            check_tensors(graph, path)?;
            check_interface(graph, &contract, path)?;
        }
        Self::new(RawModel::new(file)?, contract)
    }

    /// A policy whose graph and contract belong together; both are tried on zeros.
    pub(crate) fn new(raw: RawModel, contract: Contract) -> Result<Self, OnnxError> {
        let policy = Self { raw, contract };
        policy.try_once()?;
        Ok(policy)
    }

    /// The file's self-description.
    pub fn contract(&self) -> &Contract {
        &self.contract
    }

    /// A metadata entry.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.raw.metadata(key)
    }

    /// The zero state with which the policy starts.
    pub fn initial_state(&self) -> OnnxState {
        let n = self.contract.recurrent.map_or(0, |r| r.layers * r.hidden);
        OnnxState { h: vec![0.0; n], c: vec![0.0; n] }
    }

    /// The actions `[joints]` for one observation `[observation]` (not normalized: the file does that); advances `state`.
    ///
    /// # Errors
    /// [`OnnxError::Input`] if the observation or the state has the wrong size or the observation is not finite;
    /// [`OnnxError::Graph`] if the runtime fails.
    pub fn act(&self, obs: &[f32], state: &mut OnnxState) -> Result<Vec<f32>, OnnxError> {
        self.act_with(obs, 0.0, state)
    }

    /// [`Self::act`] in the mirror, of a policy whose graph has that input: observation and actions are those of the world. `state` is
    /// that of the mirrored world, so a policy with memory changes sides only with a fresh one.
    ///
    /// # Errors
    /// As [`Self::act`], and [`OnnxError::Input`] if the graph has no such input.
    pub fn act_in_mirror(&self, obs: &[f32], state: &mut OnnxState) -> Result<Vec<f32>, OnnxError> {
        if !self.has_mirror() {
            let (expected, found) = ("a policy that is played in it".to_owned(), "another".to_owned());
            return Err(OnnxError::Input { what: MIRROR, expected, found });
        }
        self.act_with(obs, 1.0, state)
    }

    fn has_mirror(&self) -> bool {
        self.raw.shape(MIRROR).is_some()
    }

    fn act_with(&self, obs: &[f32], mirror: f32, state: &mut OnnxState) -> Result<Vec<f32>, OnnxError> {
        let mirror = [mirror];
        let size = self.contract.observation_size();
        let wrong = |what, expected: usize, found: usize| OnnxError::Input {
            what,
            expected: format!("{expected} numbers"),
            found: format!("{found}"),
        };
        if obs.len() != size {
            return Err(wrong("observation", size, obs.len()));
        }
        if let Some(i) = obs.iter().position(|v| !v.is_finite()) {
            return Err(OnnxError::Input {
                what: "observation",
                expected: "finite numbers".to_owned(),
                found: format!("{} at {i}", obs[i]),
            });
        }
        let numbers = self.contract.recurrent.map_or(0, |r| r.layers * r.hidden);
        for (what, v) in [("hidden state", &state.h), ("cell state", &state.c)] {
            if v.len() != numbers {
                return Err(wrong(what, numbers, v.len()));
            }
        }
        let mut inputs = vec![("obs", vec![1, size], obs)];
        let mut outputs = vec![("actions", self.contract.joints.len())];
        if self.has_mirror() {
            inputs.push((MIRROR, vec![1, 1], &mirror));
        }
        if let Some(r) = self.contract.recurrent {
            let shape = vec![r.layers, 1, r.hidden];
            inputs.extend([("h_in", shape.clone(), &state.h[..]), ("c_in", shape, &state.c[..])]);
            outputs.extend([("h_out", numbers), ("c_out", numbers)]);
        }
        let mut results = self.raw.run(&inputs, &outputs)?.into_iter();
        let actions = results.next().unwrap_or_default();
        if let (Some(h), Some(c)) = (results.next(), results.next()) {
            *state = OnnxState { h, c };
        }
        Ok(actions)
    }

    /// The embedded reference's arrays at a frame, by output name in the released order; empty if the file carries none.
    /// Frames after the last give the last.
    ///
    /// # Errors
    /// [`OnnxError::Graph`] if the runtime fails.
    pub fn reference(&self, frame: usize) -> Result<Vec<(&'static str, Vec<f32>)>, OnnxError> {
        if self.contract.reference.is_none() {
            return Ok(Vec::new());
        }
        let outputs: Vec<_> =
            reference_shapes(&self.contract).map(|(n, s)| (n, s.iter().product())).collect();
        let values = self.raw.run(&[("time_step", vec![1, 1], &[frame as f32])], &outputs)?;
        Ok(outputs.iter().map(|(name, _)| *name).zip(values).collect())
    }

    /// Runs the graph on zeros, so that layers that do not fit each other are found on loading.
    fn try_once(&self) -> Result<(), OnnxError> {
        self.act(&vec![0.0; self.contract.observation_size()], &mut self.initial_state())?;
        self.reference(0)?;
        Ok(())
    }
}

/// Names and shapes of the reference's outputs, in the released order.
fn reference_shapes(contract: &Contract) -> impl Iterator<Item = (&'static str, Vec<usize>)> {
    let (joints, bodies) = (contract.joints.len(), contract.bodies.len());
    Reference::shapes(joints, bodies).into_iter().map(|(name, shape)| (name, [vec![1], shape].concat()))
}

pub(crate) fn check_opset(model: &ModelProto, path: &Path) -> Result<(), OnnxError> {
    let found: Vec<String> = (model.opset_import.iter())
        .map(|o| format!("{}{}", o.domain.as_deref().unwrap_or_default(), o.version.unwrap_or(0)))
        .collect();
    if found == [OPSET.to_string()] {
        return Ok(());
    }
    let found = if found.is_empty() { "none".to_owned() } else { found.join(", ") };
    Err(OnnxError::Opset { path: path.to_owned(), expected: OPSET, found })
}

pub(crate) fn check_metadata(model: &ModelProto, path: &Path) -> Result<Contract, OnnxError> {
    let owned = || path.to_owned();
    let get = |key: &'static str| {
        (model.metadata_props.iter())
            .find(|e| e.key.as_deref() == Some(key))
            .and_then(|e| e.value.as_deref())
            .ok_or_else(|| OnnxError::MissingMetadata { path: owned(), key })
    };
    let bad = |key: &str, reason: String| OnnxError::Metadata { path: owned(), key: key.to_owned(), reason };
    let text = get(CONTRACT_KEY)?;
    // The format first: a newer contract may have other keys.
    let json: serde_json::Value = serde_json::from_str(text).map_err(|e| bad(CONTRACT_KEY, e.to_string()))?;
    let found = json.get("format").and_then(serde_json::Value::as_u64);
    let found = found.ok_or_else(|| bad(CONTRACT_KEY, "'format' is missing or no number".to_owned()))?;
    let contract: Contract = serde_json::from_value(json).map_err(|e| match e.to_string() {
        reason if found > u64::from(FORMAT) => {
            OnnxError::ContractFormat { path: owned(), expected: FORMAT, found, reason }
        }
        reason => bad(CONTRACT_KEY, reason),
    })?;
    contract.check().map_err(|reason| bad(CONTRACT_KEY, reason))?;
    for key in RELEASED_KEYS {
        get(key)?;
    }
    for (key, expected) in released_metadata(&contract) {
        let found = get(key)?;
        if found != expected {
            let reason = format!("contradicts the contract: expected '{expected}', found '{found}'");
            return Err(bad(key, reason));
        }
    }
    Ok(contract)
}

/// Every constant holds as many bytes as its shape says, and every float is finite.
pub(crate) fn check_tensors(graph: &GraphProto, path: &Path) -> Result<(), OnnxError> {
    for t in &graph.initializer {
        let what = format!("tensor '{}'", t.name.as_deref().unwrap_or_default());
        let bytes = t.raw_data.as_deref().unwrap_or_default();
        let shape = |expected: String, found: String| OnnxError::Shape {
            path: path.to_owned(),
            what: what.clone(),
            expected,
            found,
        };
        let width: usize = match t.data_type {
            Some(FLOAT) => 4,
            Some(INT64) => 8,
            other => return Err(shape("float or int64".to_owned(), format!("data type {other:?}"))),
        };
        let size = (t.dims.iter()).try_fold(width, |n, &d| n.checked_mul(usize::try_from(d).ok()?));
        if size != Some(bytes.len()) {
            return Err(shape(format!("{:?} = {size:?} bytes", t.dims), format!("{} bytes", bytes.len())));
        }
        if t.data_type == Some(FLOAT) {
            let bad =
                bytes.chunks_exact(4).position(|b| !f32::from_le_bytes([b[0], b[1], b[2], b[3]]).is_finite());
            if let Some(i) = bad {
                return Err(shape("finite numbers".to_owned(), format!("NaN or infinity at element {i}")));
            }
        }
    }
    Ok(())
}

/// Inputs and outputs have the names and shapes that follow from the contract.
fn check_interface(graph: &GraphProto, contract: &Contract, path: &Path) -> Result<(), OnnxError> {
    let joints = contract.joints.len();
    let state = contract.recurrent.map(|r| vec![r.layers, 1, r.hidden]);
    let mut inputs = vec![("obs", vec![1, contract.observation_size()])];
    let mut outputs = vec![("actions", vec![1, joints])];
    if let Some(state) = state {
        inputs.extend([("h_in", state.clone()), ("c_in", state.clone())]);
        outputs.extend([("h_out", state.clone()), ("c_out", state)]);
    }
    // Files of the first format left the mirror to the player.
    if contract.format > 1 && contract.play.as_ref().is_some_and(|play| play.mirror_left_kicks) {
        inputs.push((MIRROR, vec![1, 1]));
    }
    inputs.push(("time_step", vec![1, 1]));
    if contract.reference.is_some() {
        outputs.extend(reference_shapes(contract));
    }
    for (kind, expected, found) in [("input", inputs, &graph.input), ("output", outputs, &graph.output)] {
        let shape = |what: String, expected: String, found: String| {
            Err(OnnxError::Shape { path: path.to_owned(), what, expected, found })
        };
        for (name, dims) in &expected {
            let what = format!("{kind} '{name}'");
            let Some(value) = found.iter().find(|v| v.name.as_deref() == Some(name)) else {
                return shape(what, format!("{dims:?}"), "nothing".to_owned());
            };
            let own = ValueInfo::shape(value);
            let dims: Vec<i64> = dims.iter().map(|&d| d as i64).collect();
            if own.as_ref() != Some(&dims) {
                let found = own.map_or_else(|| "no fixed shape".to_owned(), |s| format!("{s:?}"));
                return shape(what, format!("{dims:?}"), found);
            }
        }
        if found.len() != expected.len() {
            let names = found.iter().map(|v| v.name.as_deref().unwrap_or_default()).collect::<Vec<_>>();
            return shape(format!("{kind}s"), format!("{} of them", expected.len()), names.join(", "));
        }
    }
    Ok(())
}
