//! Policies with the interface of PAiD's public release, which do not carry this project's contract.
//!
//! Their metadata name joints, gains, default pose and action scales; what an observation term means is known from the release
//! only, so the caller's contract is the template, and everything that the file does say is
//! compared with it.

use std::path::Path;

use paid_policy::Contract;
use paid_policy::contract::{JointContract, RecurrentContract};

use crate::error::OnnxError;
use crate::raw::{OnnxFile, RawModel};
use crate::read::OnnxPolicy;

/// Reads a policy with the released interface. The contract that it gets is `template` with the file's joints (in the file's
/// order), gains, default pose, scales and recurrent state.
///
/// # Errors
/// A missing metadata entry, a list of the wrong length, an entry that is no number; [`OnnxError::ContractDiffers`] with
/// every joint, body or size that is not the template's; a graph without the released inputs and outputs.
pub fn load_released(path: &Path, template: &Contract) -> Result<OnnxPolicy, OnnxError> {
    released_policy(OnnxFile::read(path)?, template)
}

/// As [`load_released`], from a file that was read.
///
/// # Errors
/// As [`load_released`].
pub fn released_policy(file: OnnxFile, template: &Contract) -> Result<OnnxPolicy, OnnxError> {
    let raw = RawModel::new(file)?;
    let contract = contract_of(&raw, template)?;
    OnnxPolicy::new(raw, contract)
}

/// The released interface's metadata, in the order of [`crate::RELEASED_KEYS`] without `run_path`.
pub(crate) fn released_metadata(contract: &Contract) -> Vec<(&'static str, String)> {
    let joints = |f: fn(&JointContract) -> f64| {
        contract.joints.iter().map(|j| format!("{:.9}", f(j))).collect::<Vec<_>>().join(",")
    };
    let names = |i: &mut dyn Iterator<Item = &String>| i.cloned().collect::<Vec<_>>().join(",");
    vec![
        ("joint_names", names(&mut contract.joints.iter().map(|j| &j.name))),
        ("joint_stiffness", joints(|j| j.stiffness)),
        ("joint_damping", joints(|j| j.damping)),
        ("default_joint_pos", joints(|j| j.default_pos)),
        ("action_scale", joints(|j| j.action_scale)),
        ("observation_names", names(&mut contract.observation.iter().map(|t| &t.name))),
        ("command_names", names(&mut contract.commands.iter())),
        ("anchor_body_name", contract.anchor_body.clone()),
        ("body_names", names(&mut contract.bodies.iter())),
    ]
}

fn contract_of(raw: &RawModel, template: &Contract) -> Result<Contract, OnnxError> {
    let text = |key: &'static str| {
        raw.metadata(key).ok_or_else(|| OnnxError::MissingMetadata { path: raw.path().to_owned(), key })
    };
    let list = |key: &'static str| -> Result<Vec<String>, OnnxError> {
        Ok(text(key)?.split(',').map(|s| s.trim().to_owned()).collect())
    };
    let names = list("joint_names")?;
    let numbers = |key: &'static str| -> Result<Vec<f64>, OnnxError> {
        let bad =
            |reason: String| OnnxError::Metadata { path: raw.path().to_owned(), key: key.to_owned(), reason };
        let entries = list(key)?;
        if entries.len() != names.len() {
            return Err(bad(format!(
                "expected {} numbers (joint_names), found {}",
                names.len(),
                entries.len()
            )));
        }
        let number = |(i, entry): (usize, &String)| match entry.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            _ => Err(bad(format!("entry {i}: expected a finite number, found '{entry}'"))),
        };
        entries.iter().enumerate().map(number).collect()
    };
    let (stiffness, damping) = (numbers("joint_stiffness")?, numbers("joint_damping")?);
    let (default_pos, scale) = (numbers("default_joint_pos")?, numbers("action_scale")?);
    let joints = names.iter().enumerate().map(|(i, name)| JointContract {
        name: name.clone(),
        default_pos: default_pos[i],
        stiffness: stiffness[i],
        damping: damping[i],
        action_scale: scale[i],
    });
    let joints: Vec<JointContract> = joints.collect();

    let mut differences = Vec::new();
    let mut compare = |what: &str, expected: String, found: String| {
        if expected != found {
            differences.push(format!("{what}: expected {expected}, found {found}"));
        }
    };
    // Joints may come in any order, but they must be the same ones.
    let sorted = |mut names: Vec<String>| {
        names.sort();
        names.join(",")
    };
    compare("joint_names", sorted(template.joints.iter().map(|j| j.name.clone()).collect()), sorted(names));
    compare("body_names", template.bodies.join(","), list("body_names")?.join(","));
    compare("anchor_body_name", template.anchor_body.clone(), text("anchor_body_name")?.trim().to_owned());
    let shape = |name: &str| match raw.shape(name) {
        None => "nothing".to_owned(),
        Some(None) => "no fixed shape".to_owned(),
        Some(Some(shape)) => format!("{shape:?}"),
    };
    compare("input 'obs'", format!("[1, {}]", template.observation_size()), shape("obs"));
    compare("output 'actions'", format!("[1, {}]", template.joints.len()), shape("actions"));
    let recurrent = match raw.shape("h_in") {
        None => None,
        Some(state) => {
            compare("input 'c_in'", shape("h_in"), shape("c_in"));
            compare("output 'h_out'", shape("h_in"), shape("h_out"));
            compare("output 'c_out'", shape("h_in"), shape("c_out"));
            match state.as_deref() {
                Some(&[layers, 1, hidden]) if layers > 0 && hidden > 0 => {
                    Some(RecurrentContract { layers: layers as usize, hidden: hidden as usize })
                }
                _ => {
                    compare("input 'h_in'", "[layers, 1, hidden]".to_owned(), shape("h_in"));
                    None
                }
            }
        }
    };
    if !differences.is_empty() {
        return Err(OnnxError::ContractDiffers { path: raw.path().to_owned(), differences });
    }
    let contract = Contract { joints, recurrent, reference: None, ..template.clone() };
    contract.check().map_err(|reason| OnnxError::Metadata {
        path: raw.path().to_owned(),
        key: "joint_names".to_owned(),
        reason,
    })?;
    Ok(contract)
}
