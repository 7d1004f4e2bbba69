//! Checkpoints: a policy's weights, and in a full checkpoint everything that its learner needs to continue as if it had not stopped, in
//! one safetensors file.
//!
//! Tensors: `actor.*`, `critic.*` (weights, `actor.log_std`), `adam.m.*`, `adam.v.*`, `normalizer.{policy,critic}.{mean,m2,count}`
//! (`f64`), `learner.*` (rates and counters), `carry.<shard>.{actor,critic}` (recurrent state, `[2 * layers * size, envs]`: `h` then
//! `c` of each layer) and `blob.<name>` (bytes that the caller added). A reward that the learner computes adds `reward.<name>` (its state, bytes)
//! and, if it has a critic of its own, `critic_<name>.*` with moments and carry. The metadata hold the shape of the networks as JSON.

mod inputs;
mod of_policy;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::config::{MOST_WIDTH, NetworkConfig};
use crate::net::{Layout, Network};
use crate::normalizer::{Moments, Normalizer};
use crate::policy::Policy;
use crate::tensor_file::TensorFile;

/// Version of the format.
pub const VERSION: u32 = 1;

/// A checkpoint that cannot be written, read or used.
#[derive(Debug, thiserror::Error)]
pub enum CheckpointError {
    /// The file system refused.
    #[error("{}: cannot {action}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What was tried.
        action: &'static str,
        /// Why it failed.
        source: std::io::Error,
    },
    /// The file is not a checkpoint of this program.
    #[error("{}: not a checkpoint: {reason}", path.display())]
    Format {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        reason: String,
    },
    /// A tensor is missing or has another shape than the learner's.
    #[error(
        "{}: checkpoint of another architecture: tensor {tensor}: expected {expected}, found {found}",
        path.display()
    )]
    Tensor {
        /// The file.
        path: PathBuf,
        /// The tensor.
        tensor: String,
        /// What the learner has.
        expected: String,
        /// What the file has.
        found: String,
    },
}

/// Beginnings of the names of what a policy and its critics are; the rest is for resuming.
const WEIGHTS: [&str; 4] = ["actor.", "critic.", "critic_", "normalizer."];

/// Shape of the learner that wrote a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Meta {
    /// Version of the format.
    pub version: u32,
    /// Features of the policy's observation.
    pub policy_obs: usize,
    /// Features of the critic's observation.
    pub critic_obs: usize,
    /// Number of actions.
    pub actions: usize,
    /// Policy network.
    pub actor: NetworkConfig,
    /// Value network.
    pub critic: NetworkConfig,
    /// Iterations done.
    pub iteration: u64,
}

impl Meta {
    /// Checks the sizes. A damaged file may state any, and the networks are made by them.
    fn check(&self) -> Result<(), String> {
        for (key, size) in
            [("policy_obs", self.policy_obs), ("critic_obs", self.critic_obs), ("actions", self.actions)]
        {
            if !(1..=MOST_WIDTH).contains(&size) {
                return Err(format!("{key}: expected 1 to {MOST_WIDTH}, found {size}"));
            }
        }
        for (name, network, features) in
            [("actor", &self.actor, self.policy_obs), ("critic", &self.critic, self.critic_obs)]
        {
            network.check_for(features).map_err(|error| format!("{name}.{error}"))?;
        }
        Ok(())
    }
}

/// A checkpoint in memory.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    file: TensorFile,
    meta: Meta,
}

impl Checkpoint {
    /// Reads a checkpoint.
    ///
    /// # Errors
    /// If the file cannot be read or is none.
    pub fn load(path: &Path) -> Result<Self, CheckpointError> {
        Self::of(TensorFile::load(path)?)
    }

    /// As [`Checkpoint::load`], from a file's bytes; `path` only names them in errors.
    ///
    /// # Errors
    /// If they are no checkpoint.
    pub fn from_bytes(bytes: &[u8], path: &Path) -> Result<Self, CheckpointError> {
        Self::of(TensorFile::from_bytes(bytes, path)?)
    }

    fn of(file: TensorFile) -> Result<Self, CheckpointError> {
        let wrong = |reason: String| CheckpointError::Format { path: file.path.clone(), reason };
        let text = file.metadata.get("paid").ok_or_else(|| wrong("no metadata entry 'paid'".to_owned()))?;
        // The version first: a newer program's metadata may have keys that this one cannot honor.
        let json: serde_json::Value =
            serde_json::from_str(text).map_err(|error| wrong(format!("metadata: {error}")))?;
        let version = json.get("version").and_then(serde_json::Value::as_u64).unwrap_or_default();
        let meta: Meta = serde_json::from_value(json).map_err(|error| {
            wrong(if version > u64::from(VERSION) {
                format!(
                    "it has format {version}, which is newer than this program's format {VERSION}, and cannot be read ({error}); use \
                     the program that wrote it"
                )
            } else {
                format!("metadata: {error}")
            })
        })?;
        meta.check().map_err(|error| wrong(format!("metadata: {error}")))?;
        Ok(Self { file, meta })
    }

    /// Writes its metadata into the file.
    fn describe(&mut self) -> Result<(), CheckpointError> {
        let text = serde_json::to_string(&self.meta).map_err(|error| CheckpointError::Format {
            path: self.file.path.clone(),
            reason: error.to_string(),
        })?;
        self.file.metadata.insert("paid".to_owned(), text);
        Ok(())
    }

    /// The file that it came from.
    pub fn path(&self) -> &Path {
        &self.file.path
    }

    /// All of its tensors.
    pub fn tensors(&self) -> &TensorFile {
        &self.file
    }

    /// Shape of the learner that wrote it.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// Bytes that the caller of `save` added under a name.
    pub fn blob(&self, name: &str) -> Option<&[u8]> {
        self.file.tensors.get(&format!("blob.{name}")).map(|tensor| tensor.data.as_slice())
    }

    /// Puts other bytes under a name, in memory.
    pub fn set_blob(&mut self, name: &str, bytes: &[u8]) {
        self.file.put_bytes(format!("blob.{name}"), bytes);
    }

    /// The names of all such bytes, sorted.
    pub fn blob_names(&self) -> Vec<&str> {
        self.file.tensors.keys().filter_map(|name| name.strip_prefix("blob.")).collect()
    }

    /// The policy, for evaluation and export.
    ///
    /// # Errors
    /// If a tensor does not fit the metadata.
    pub fn policy(&self) -> Result<Policy, CheckpointError> {
        let net = Network::new(self.meta.policy_obs, self.meta.actions, &self.meta.actor);
        let params = self.parameters("actor", net.layout())?;
        let log_std = self.file.f32s("actor.log_std", &[self.meta.actions])?;
        let std = log_std.iter().map(|x| x.exp()).collect();
        let normalizer = self.normalizer("policy", self.meta.policy_obs)?;
        Ok(Policy { net, params, normalizer, std })
    }

    /// The same with the mean of its own and `others`' weights and normalizers: late in a training it is often better than any
    /// of them. What is for resuming is left out.
    ///
    /// # Errors
    /// If a tensor of another checkpoint is missing, has another shape or is not finite.
    pub fn mean_with(&self, others: &[Self]) -> Result<Self, CheckpointError> {
        let mut mean = self.clone();
        mean.file.tensors.retain(|name, _| name.starts_with("blob.") || is_weight(name));
        let count = (others.len() + 1) as f64;
        for (name, tensor) in mean.file.tensors.iter_mut().filter(|(name, _)| is_weight(name)) {
            let mut sum = self.file.numbers(name, &tensor.shape)?;
            for other in others {
                for (sum, x) in sum.iter_mut().zip(other.file.numbers(name, &tensor.shape)?) {
                    *sum += x;
                }
            }
            tensor.set_numbers(sum.iter().map(|x| x / count));
        }
        Ok(mean)
    }

    /// Writes all that it holds back to its file, with the bytes that [`Checkpoint::set_blob`] has put into it; the file stays whole if
    /// this fails.
    ///
    /// # Errors
    /// If a tensor does not fit the metadata or the file system refuses.
    pub fn save(&self) -> Result<(), CheckpointError> {
        self.policy()?;
        self.file.save()
    }

    /// Writes weights and normalizers with the caller's `blobs` and nothing else: enough for evaluation, export and
    /// a start with these weights, not for resuming. States of environments, which come from motions, stay behind.
    ///
    /// # Errors
    /// If a tensor does not fit the metadata or the file system refuses.
    pub fn save_weights(&self, path: &Path, blobs: &[(&str, &[u8])]) -> Result<(), CheckpointError> {
        self.policy()?;
        let tensors = self.file.tensors.iter().filter(|(name, _)| is_weight(name));
        let mut file = TensorFile {
            path: path.to_owned(),
            tensors: tensors.map(|(name, tensor)| (name.clone(), tensor.clone())).collect(),
            metadata: self.file.metadata.clone(),
        };
        for (name, bytes) in blobs {
            file.put_bytes(format!("blob.{name}"), bytes);
        }
        file.save()
    }

    /// All tensors of a layout, `prefix.` before their names, each checked by name and shape.
    ///
    /// # Errors
    /// Naming the first tensor that is missing, has another shape or a number that is not finite.
    pub fn parameters(&self, prefix: &str, layout: &Layout) -> Result<Vec<f32>, CheckpointError> {
        // It grows with what the file has: the layout is only what the metadata promise.
        let mut params = Vec::new();
        for spec in layout.tensors() {
            params.extend(self.file.f32s(&format!("{prefix}.{}", spec.name), &spec.shape)?);
        }
        Ok(params)
    }

    /// The normalizer `policy` or `critic`.
    ///
    /// # Errors
    /// If its tensors are missing, have another shape or a number that is not finite or that no samples have.
    pub fn normalizer(&self, name: &str, features: usize) -> Result<Normalizer, CheckpointError> {
        let mean = self.file.f64s(&format!("normalizer.{name}.mean"), &[features])?;
        let m2 = self.file.f64s(&format!("normalizer.{name}.m2"), &[features])?;
        let count = self.file.f64s(&format!("normalizer.{name}.count"), &[1])?[0];
        let moments = Moments { count, mean, m2 };
        moments.check().map_err(|error| CheckpointError::Format {
            path: self.file.path.clone(),
            reason: format!("tensor normalizer.{name}.{error}"),
        })?;
        Ok(Normalizer::from_moments(moments))
    }
}

fn is_weight(name: &str) -> bool {
    WEIGHTS.iter().any(|prefix| name.starts_with(prefix))
}
