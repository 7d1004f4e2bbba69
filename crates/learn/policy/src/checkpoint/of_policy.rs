//! A checkpoint of a policy alone: what a run needs to begin as it.

use std::collections::BTreeMap;
use std::path::Path;

use super::{Checkpoint, CheckpointError, Meta, VERSION};
use crate::config::NetworkConfig;
use crate::normalizer::Moments;
use crate::policy::Policy;
use crate::tensor_file::TensorFile;

/// A policy file does not say of how many samples its normalizer is made. It counts as this many, a run's worth, so that further ones move it
/// slowly.
const SAMPLES: f64 = 1e8;

impl Checkpoint {
    /// The weights of a policy whose learner is unknown, without a critic. `networks` are actor and critic of the run that trained it; `path`
    /// only names it in errors.
    ///
    /// # Errors
    /// If the policy is not of the actor's network.
    pub fn of_policy(
        policy: &Policy,
        [actor, critic]: [&NetworkConfig; 2],
        path: &Path,
    ) -> Result<Self, CheckpointError> {
        let meta = Meta {
            version: VERSION,
            policy_obs: policy.obs_dim(),
            critic_obs: policy.obs_dim(), // any: there is none
            actions: policy.action_dim(),
            actor: actor.clone(),
            critic: critic.clone(),
            iteration: 0,
        };
        let file = TensorFile { path: path.to_owned(), tensors: BTreeMap::new(), metadata: BTreeMap::new() };
        let mut checkpoint = Self { file, meta };
        let file = &mut checkpoint.file;
        for spec in policy.net.layout().tensors() {
            file.put_f32s(format!("actor.{}", spec.name), &spec.shape, &policy.params[spec.range.clone()]);
        }
        let log_std: Vec<f32> = policy.std.iter().map(|std| std.ln()).collect();
        file.put_f32s("actor.log_std".to_owned(), &[log_std.len()], &log_std);
        let Moments { count, mean, m2 } = policy.normalizer.moments();
        let m2: Vec<f64> = m2.iter().map(|m2| m2 / count.max(1.0) * SAMPLES).collect();
        for (what, values) in [("mean", mean), ("m2", &m2), ("count", &vec![SAMPLES])] {
            file.put_f64s(format!("normalizer.policy.{what}"), &[values.len()], values);
        }
        checkpoint.describe()?;
        checkpoint.policy()?;
        Ok(checkpoint)
    }

    /// True unless it is of a policy alone.
    pub fn has_critic(&self) -> bool {
        self.file.tensors.keys().any(|name| name.starts_with("critic."))
    }
}
