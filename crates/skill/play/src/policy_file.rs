//! Reading a policy: its network, the robot that it was trained for, and how it is played.

use std::fs;
use std::path::{Path, PathBuf};

use paid_onnx::{OnnxError, OnnxFile, StoredPolicy};
use paid_policy::{Checkpoint, CheckpointError, Contract, Dimensions, ObservationTerms, Policy};
use paid_robot::{RobotModel, RobotSpec};
use serde::Deserialize;
use toml::Table;

use crate::preset::wrong;
use crate::{PlayError, PlayPreset, policy_contract};

/// Name of a run's resolved preset, in its folder and in its checkpoints.
pub const PRESET_FILE: &str = "preset.toml";

/// Name of the policy in a run folder.
pub const POLICY_FILE: &str = "policy.onnx";
/// What is wrong with an ONNX file that only runs.
pub const NO_PRESET: &str =
    "expected a policy with its preset, found an ONNX file without; take the checkpoint that it comes from";

/// True if the name is that of an ONNX file.
pub fn is_onnx(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("onnx"))
}

/// A robot by name (`g1` is built in) or by the path of its TOML, whose MJCF lies next to it under the same name.
///
/// # Errors
/// File, line, expected and found.
pub fn load_robot(robot: &str) -> Result<(RobotModel, RobotSpec), PlayError> {
    if robot == "g1" {
        return Ok((RobotModel::g1(), RobotSpec::g1()));
    }
    let toml = Path::new(robot);
    if toml.extension().is_none_or(|e| e != "toml") {
        return Err(PlayError::Robot(format!("expected 'g1' or the path of a .toml file, found '{robot}'")));
    }
    let mjcf = toml.with_extension("xml");
    let text = |path: &Path| {
        fs::read_to_string(path)
            .map_err(|error| PlayError::Read { path: path.to_owned(), reason: error.to_string() })
    };
    let spec = RobotSpec::from_toml(&text(toml)?, robot).map_err(|e| PlayError::RobotFile(e.to_string()))?;
    let model = RobotModel::from_mjcf(&text(&mjcf)?, &mjcf.to_string_lossy())
        .map_err(|e| PlayError::RobotFile(e.to_string()))?;
    Ok((model, spec))
}

/// A policy and what it takes to play it.
#[derive(Clone, Debug)]
pub struct PolicyFile {
    /// The file.
    pub path: PathBuf,
    /// Folder of the motions that the policy was trained on, as its run named it.
    pub motions: String,
    /// How it is played.
    pub play: PlayPreset,
    /// What was changed of that, each `KEY=VALUE`.
    pub sets: Vec<String>,
    /// Tree, limits.
    pub model: RobotModel,
    /// Gains and names.
    pub spec: RobotSpec,
    /// Network and normalizer.
    pub policy: Policy,
}

/// What a player reads of a run preset.
#[derive(Deserialize)]
struct Run {
    robot: String,
    run: Motions,
    task: Table,
}

#[derive(Deserialize)]
struct Motions {
    motions: String,
}

impl PolicyFile {
    /// Reads a policy from a policy file, a checkpoint, or a run folder, whose policy file it reads; `sets` are changed values of how it is
    /// played, each `KEY=VALUE`.
    ///
    /// # Errors
    /// If the file cannot be read, holds no preset or one without what a player needs, its sizes are not those of its robot,
    /// or a change is not about how it is played.
    pub fn load(path: &Path, sets: &[String]) -> Result<Self, PlayError> {
        let fail = |message: String| PlayError::File { path: path.to_owned(), message };
        if path.is_dir() {
            let file = path.join(POLICY_FILE);
            if !file.is_file() {
                return Err(fail(format!(
                    "expected a policy, found a folder without {POLICY_FILE}; paid export writes one"
                )));
            }
            return Self::load(&file, sets);
        }
        let (preset, policy) = if is_onnx(path) { of_onnx(path)? } else { of_checkpoint(path)? };
        let read = || {
            let Run { robot, run, task } = toml::from_str(&preset).map_err(|error| wrong(&error))?;
            Self::new(path.to_owned(), &robot, run.motions, PlayPreset::of_task(task)?, policy)
        };
        let file = read().map_err(|error| match error {
            PlayError::Preset(_) | PlayError::Value { .. } => fail(error.to_string()),
            error => error,
        })?;
        Ok(Self { play: file.play.with_overrides(sets)?, sets: sets.to_vec(), ..file })
    }

    /// Puts the parts together.
    ///
    /// # Errors
    /// If the robot cannot be read, or the policy's sizes are not the robot's.
    pub fn new(
        path: PathBuf,
        robot: &str,
        motions: String,
        play: PlayPreset,
        policy: Policy,
    ) -> Result<Self, PlayError> {
        let (model, spec) = load_robot(robot)?;
        let terms = ObservationTerms::new(&play.observations.policy, Dimensions::of(&spec));
        let expected = (terms.dim(), spec.policy_joint_order.len());
        let found = (policy.obs_dim(), policy.action_dim());
        if expected != found {
            let message = format!(
                "expected {} observations and {} actions (robot '{}'), found {} and {}",
                expected.0, expected.1, spec.name, found.0, found.1
            );
            return Err(PlayError::File { path, message });
        }
        Ok(Self { path, motions, play, sets: Vec::new(), model, spec, policy })
    }

    /// See [`policy_contract`].
    ///
    /// # Errors
    /// If the robot's gains cannot be resolved.
    pub fn contract(&self, license: &str) -> Result<Contract, PlayError> {
        policy_contract(&self.model, &self.spec, &self.play, &self.policy, license)
    }
}

/// Preset and network of a policy file.
fn of_onnx(path: &Path) -> Result<(String, Policy), PlayError> {
    let unread = |error: OnnxError| PlayError::Unreadable(error.to_string());
    let stored = OnnxFile::read(path).and_then(|file| file.stored()).map_err(unread)?;
    let StoredPolicy { preset, policy, .. } =
        stored.ok_or_else(|| PlayError::File { path: path.to_owned(), message: NO_PRESET.to_owned() })?;
    Ok((preset, policy))
}

/// Preset and network of a checkpoint.
fn of_checkpoint(path: &Path) -> Result<(String, Policy), PlayError> {
    let unread = |error: CheckpointError| PlayError::Unreadable(error.to_string());
    let fail = |message: String| PlayError::File { path: path.to_owned(), message };
    let checkpoint = Checkpoint::load(path).map_err(unread)?;
    let preset = checkpoint.blob(PRESET_FILE);
    let preset =
        preset.ok_or_else(|| fail(format!("expected an entry '{PRESET_FILE}' (text), found none")))?;
    let preset = std::str::from_utf8(preset).map_err(|error| fail(format!("{PRESET_FILE}: {error}")))?;
    Ok((preset.to_owned(), checkpoint.policy().map_err(unread)?))
}
