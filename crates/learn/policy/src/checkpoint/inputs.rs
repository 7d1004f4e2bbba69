//! Weights for other inputs: the same policy that is shown more, or in another order.

use std::collections::BTreeSet;

use super::{Checkpoint, CheckpointError, Meta, is_weight};
use crate::net::{Network, TensorSpec};

/// Weight matrices that read a network's input, and for each of their inputs its number before, `None` for a new one.
type FirstLayers<'n> = Vec<(&'n TensorSpec, Vec<Option<usize>>)>;

impl Checkpoint {
    /// The same with other inputs of the policy, for a start with these weights: input `k` is the one numbered `from[k]` here, or a
    /// new one, which weighs nothing and counts as normalized. What is for resuming is left out.
    ///
    /// # Errors
    /// If a tensor is missing, has another shape or is not finite.
    ///
    /// # Panics
    /// If `from` names an input that does not exist.
    pub fn with_policy_inputs(&self, from: &[Option<usize>]) -> Result<Self, CheckpointError> {
        let net = Network::new(self.meta.policy_obs, self.meta.actions, &self.meta.actor);
        let meta = Meta { policy_obs: from.len(), ..self.meta.clone() };
        self.with_inputs("policy", ["actor"], &net, from, meta)
    }

    /// As [`Checkpoint::with_policy_inputs`], of all critics, which see the same.
    ///
    /// # Errors
    /// If a tensor is missing, has another shape or is not finite.
    ///
    /// # Panics
    /// If `from` names an input that does not exist.
    pub fn with_critic_inputs(&self, from: &[Option<usize>]) -> Result<Self, CheckpointError> {
        let net = Network::new(self.meta.critic_obs, 1, &self.meta.critic);
        let meta = Meta { critic_obs: from.len(), ..self.meta.clone() };
        let names = self.file.tensors.keys().filter_map(|name| Some(name.split_once('.')?.0));
        let critics: BTreeSet<&str> =
            names.filter(|name| *name == "critic" || name.starts_with("critic_")).collect();
        self.with_inputs("critic", critics, &net, from, meta)
    }

    /// The same with other inputs of the networks of these `names`, all of them shaped as `net`, and of their normalizer.
    fn with_inputs<'a>(
        &self,
        normalizer: &str,
        names: impl IntoIterator<Item = &'a str>,
        net: &Network,
        from: &[Option<usize>],
        meta: Meta,
    ) -> Result<Self, CheckpointError> {
        let (old, new) = (net.input, from.len());
        let rearranged = |from: &[Option<usize>], row: &[f64], unknown: f64| -> Vec<f64> {
            from.iter().map(|&k| k.map_or(unknown, |k| row[k])).collect()
        };
        let first = self.new_first_layers(net, from)?;
        let mut other = Self { file: self.file.clone(), meta };
        other.file.tensors.retain(|name, _| name.starts_with("blob.") || is_weight(name));
        for network in names {
            for (spec, from) in &first {
                let (name, rows) = (format!("{network}.{}", spec.name), spec.shape[0]);
                let weights = self.file.numbers(&name, &spec.shape)?;
                let weights = weights.chunks(spec.shape[1]).flat_map(|row| rearranged(from, row, 0.0));
                let weights: Vec<f32> = weights.map(|x| x as f32).collect();
                other.file.put_f32s(name, &[rows, from.len()], &weights);
            }
        }
        let moments = self.normalizer(normalizer, old)?.moments().clone();
        let mut put = |what: &str, values: &[f64]| {
            other.file.put_f64s(format!("normalizer.{normalizer}.{what}"), &[new], values);
        };
        put("mean", &rearranged(from, &moments.mean, 0.0));
        put("m2", &rearranged(from, &moments.m2, moments.count));
        other.describe()?;
        Ok(other)
    }

    /// The weight matrices of `net` that read its input, and from where each of their inputs comes if the network's come `from` there.
    fn new_first_layers<'n>(
        &self,
        net: &'n Network,
        from: &[Option<usize>],
    ) -> Result<FirstLayers<'n>, CheckpointError> {
        let tensors = net.layout().tensors();
        if !net.is_beside() {
            return Ok(vec![(&tensors[0], from.to_vec())]);
        }
        // The memory reads as many of the last features as before, or all again.
        let (read, old, new) = (net.remembered_features(), net.input, from.len());
        let first = if read.len() == old { 0 } else { new.saturating_sub(read.len()) };
        let (before, now) = from.split_at(first);
        if let Some(k) = before.iter().flatten().find(|k| read.contains(*k)) {
            let reason = format!(
                "expected the {} features that its memory reads at the end of the observation, found feature {k} before them",
                read.len()
            );
            return Err(CheckpointError::Format { path: self.file.path.clone(), reason });
        }
        let memory = now.iter().map(|k| k.filter(|k| read.contains(k)).map(|k| k - read.start));
        let both = from.iter().copied().chain((old..net.mlp[0].input).map(Some));
        let mlp = tensors.iter().find(|spec| spec.range == net.mlp[0].weight);
        let mlp = mlp.map(|spec| (spec, both.collect()));
        Ok(core::iter::once((&tensors[0], memory.collect())).chain(mlp).collect())
    }
}
