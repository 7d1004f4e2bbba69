//! Saving and restoring a learner.

use std::path::Path;

use paid_policy::checkpoint::{Meta, VERSION};
use paid_policy::net::State;
use paid_policy::normalizer::Normalizer;
use paid_policy::{Checkpoint, CheckpointError, TensorFile};

use crate::learned_reward::RewardStream;
use crate::learner::Learner;
use crate::model::Model;
use crate::rollout::{RolloutLayout, World};
use crate::shard::Shard;

/// Recurrent states of a shard's blocks as one `[2 * layers * size, envs]` matrix.
fn gather(states: &[State<f32>], envs: usize) -> (usize, Vec<f32>) {
    let rows = states
        .first()
        .map_or(0, |state| state.h.iter().chain(&state.c).map(|layer| layer.len() / state.n.max(1)).sum());
    let mut out = vec![0.0; rows * envs];
    let mut first = 0;
    for state in states {
        let layers = state.h.iter().zip(&state.c).flat_map(|(h, c)| [h, c]);
        let values = layers.flat_map(|layer| layer.chunks(state.n));
        for (row, values) in values.enumerate() {
            out[row * envs + first..row * envs + first + state.n].copy_from_slice(values);
        }
        first += state.n;
    }
    (rows, out)
}

/// The reverse of [`gather`].
fn scatter(data: &[f32], states: &mut [State<f32>], envs: usize) {
    let mut first = 0;
    for state in states {
        let n = state.n;
        let layers = state.h.iter_mut().zip(&mut state.c).flat_map(|(h, c)| [h, c]);
        for (row, values) in layers.flat_map(|layer| layer.chunks_mut(n)).enumerate() {
            values.copy_from_slice(&data[row * envs + first..row * envs + first + n]);
        }
        first += n;
    }
}

/// The parameters of a network without a memory, with that of `model`, which weighs nothing.
fn with_memory(checkpoint: &Checkpoint, name: &str, model: &Model) -> Result<Vec<f32>, CheckpointError> {
    let mut params = model.params.clone();
    for spec in model.layout.tensors().iter().filter(|spec| !spec.name.starts_with("lstm.")) {
        let tensor = format!("{name}.{}", spec.name);
        let place = &mut params[spec.range.clone()];
        if spec.range == model.net.mlp[0].weight {
            let (rows, known) = (spec.shape[0], model.net.direct);
            let weights = checkpoint.tensors().f32s(&tensor, &[rows, known])?;
            place.fill(0.0);
            for (row, weights) in place.chunks_exact_mut(spec.shape[1]).zip(weights.chunks_exact(known)) {
                row[..known].copy_from_slice(weights);
            }
        } else {
            place.copy_from_slice(&checkpoint.tensors().f32s(&tensor, &spec.shape)?);
        }
    }
    Ok(params)
}

/// Beginning of the name of a learned reward's state.
const REWARD: &str = "reward.";

/// A shard's recurrent states: of each network their rows and numbers.
type Carried = Vec<(usize, Vec<f32>)>;

/// What a checkpoint knows without the optimizer.
struct Weights {
    actor: Model,
    critics: Vec<Model>,
    policy_normalizer: Normalizer,
    critic_normalizer: Normalizer,
}

impl Learner {
    /// Writes a checkpoint with the caller's `blobs` (environment states, sampler, preset); an older file stays whole if
    /// this fails. Every rank must call it; the first one writes.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn save(&self, path: &Path, blobs: &[(&str, &[u8])]) -> Result<(), CheckpointError> {
        let carried = self.carried();
        if self.ranks.rank() == 0 { self.write(path, blobs, Some(&carried)) } else { Ok(()) }
    }

    /// Writes a checkpoint without the shards' memory and the learned reward's: what an evaluation needs. No other rank takes part.
    ///
    /// # Errors
    /// If the file system refuses.
    pub fn save_policy(&self, path: &Path, blobs: &[(&str, &[u8])]) -> Result<(), CheckpointError> {
        self.write(path, blobs, None)
    }

    /// The recurrent states of all shards of all ranks: for each shard those of each network.
    fn carried(&self) -> Vec<Carried> {
        let mut own: Vec<u8> = Vec::new();
        for shard in &self.shards {
            for states in core::iter::once(&shard.actor_state).chain(&shard.critic_states) {
                let (_, data) = gather(states, shard.rollout.layout.envs);
                own.extend(data.iter().flat_map(|x| x.to_le_bytes()));
            }
        }
        let all = self.ranks.gather(&own).concat();
        let (words, _) = all.as_chunks::<4>();
        let mut numbers = words.iter().map(|word| f32::from_le_bytes(*word));
        let networks = core::iter::once(&self.actor).chain(&self.critics);
        let rows: Vec<usize> = networks.map(|model| gather(&[model.net.initial_state(1)], 1).0).collect();
        let shard = |layout: &RolloutLayout| {
            rows.iter().map(|&rows| (rows, numbers.by_ref().take(rows * layout.envs).collect())).collect()
        };
        self.world.layouts.iter().map(shard).collect()
    }

    fn write(
        &self,
        path: &Path,
        blobs: &[(&str, &[u8])],
        to_resume: Option<&[Carried]>,
    ) -> Result<(), CheckpointError> {
        let carried = to_resume.unwrap_or_default();
        let mut file = TensorFile { path: path.to_owned(), ..TensorFile::default() };
        for (name, model) in self.models() {
            for spec in model.layout.tensors() {
                for (prefix, data) in [("", &model.params), ("adam.m.", &model.m), ("adam.v.", &model.v)] {
                    let place = format!("{prefix}{name}.{}", spec.name);
                    file.put_f32s(place, &spec.shape, &data[spec.range.clone()]);
                }
            }
        }
        for (name, normalizer) in [("policy", &self.policy_normalizer), ("critic", &self.critic_normalizer)] {
            let moments = normalizer.moments();
            let features = [moments.mean.len()];
            file.put_f64s(format!("normalizer.{name}.mean"), &features, &moments.mean);
            file.put_f64s(format!("normalizer.{name}.m2"), &features, &moments.m2);
            file.put_f64s(format!("normalizer.{name}.count"), &[1], &[moments.count]);
        }
        file.put_f64s("learner.learning_rate", &[1], &[self.schedule.learning_rate]);
        let counters = [
            self.seed,
            self.iteration,
            self.env_steps,
            self.schedule.adam_step,
            self.schedule.shuffle.position(),
            carried.len() as u64,
        ];
        file.put_u64s("learner.counters", &[counters.len()], &counters);
        let layouts = self.world.layouts.iter().take(carried.len());
        let sizes: Vec<u64> = layouts.map(|layout| layout.envs as u64).collect();
        file.put_u64s("learner.shards", &[sizes.len()], &sizes);
        for (k, (networks, envs)) in carried.iter().zip(&sizes).enumerate() {
            for ((name, _), (rows, data)) in self.models().iter().zip(networks) {
                file.put_f32s(format!("carry.{k}.{name}"), &[*rows, *envs as usize], data);
            }
        }
        if let Some(stream) = self.learned.as_ref().filter(|_| to_resume.is_some()) {
            file.put_bytes(format!("{REWARD}{}", stream.reward.name()), &stream.reward.save());
        }
        for (name, bytes) in blobs {
            file.put_bytes(format!("blob.{name}"), bytes);
        }
        let meta = Meta {
            version: VERSION,
            policy_obs: self.actor.net.input,
            critic_obs: self.critics[0].net.input,
            actions: self.actor.net.output,
            actor: self.config.actor.clone(),
            critic: self.config.critic.clone(),
            iteration: self.iteration,
        };
        let text = serde_json::to_string(&meta)
            .map_err(|error| CheckpointError::Format { path: path.to_owned(), reason: error.to_string() })?;
        file.metadata.insert("paid".to_owned(), text);
        file.save()
    }

    /// Names of the networks in a checkpoint: `actor`, `critic` and, for a learned reward's own critic, `critic_<reward>`.
    fn models(&self) -> Vec<(String, &Model)> {
        let mut models = vec![("actor".to_owned(), &self.actor), ("critic".to_owned(), &self.critics[0])];
        if let (Some(critic), Some(stream)) = (self.critics.get(1), &self.learned) {
            models.push((format!("critic_{}", stream.reward.name()), critic));
        }
        models
    }

    /// The learned reward as the checkpoint has it.
    fn reward_of(&self, checkpoint: &Checkpoint) -> Result<Option<RewardStream>, CheckpointError> {
        let wrong = |reason: String| CheckpointError::Format { path: checkpoint.path().to_owned(), reason };
        let tensors = &checkpoint.tensors().tensors;
        let found = tensors.iter().find_map(|(name, tensor)| Some((name.strip_prefix(REWARD)?, tensor)));
        let expected = self.learned.as_ref().map(|stream| stream.reward.name());
        if found.map(|(name, _)| name) != expected {
            let text = |name: Option<&str>| name.map_or("none".to_owned(), |name| format!("'{name}'"));
            let found = text(found.map(|(name, _)| name));
            return Err(wrong(format!("learned reward: expected {}, found {found}", text(expected))));
        }
        let (Some((name, tensor)), Some(mut stream)) = (found, self.learned.clone()) else { return Ok(None) };
        stream
            .reward
            .restore(&tensor.data)
            .map_err(|error| wrong(format!("learned reward '{name}': {error}")))?;
        Ok(Some(stream))
    }

    /// Continues where the checkpoint stopped: weights, moments, normalizers, rates, counters, seed and recurrent states. With
    /// environments restored to the same point, training ends in the same weights as without the interruption. On an error the
    /// learner is as before.
    ///
    /// # Errors
    /// If the checkpoint is of another architecture.
    pub fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        let learned = self.reward_of(checkpoint)?;
        let names: Vec<String> = self.models().into_iter().map(|(name, _)| name).collect();
        let mut weights = self.weights_of(checkpoint, true)?;
        let models = core::iter::once(&mut weights.actor).chain(&mut weights.critics);
        for (name, model) in names.iter().zip(models) {
            model.m = checkpoint.parameters(&format!("adam.m.{name}"), &model.layout)?;
            model.v = checkpoint.parameters(&format!("adam.v.{name}"), &model.layout)?;
        }
        let file = checkpoint.tensors();
        let learning_rate = file.f64s("learner.learning_rate", &[1])?[0];
        let counters = file.u64s("learner.counters", &[6])?;
        let sizes = file.u64s("learner.shards", &[counters[5] as usize])?;
        let layouts: Vec<RolloutLayout> = sizes.iter().map(|&envs| self.layout(envs as usize)).collect();
        let (ranks, each) = (self.ranks.count(), layouts.len() / self.ranks.count());
        if !layouts.len().is_multiple_of(ranks) {
            let reason =
                format!("expected a number of shards that {ranks} ranks can share, found {}", sizes.len());
            return Err(CheckpointError::Format { path: checkpoint.path().to_owned(), reason });
        }
        let world = World { layouts, first: each * self.ranks.rank() };
        let mut shards = Vec::new();
        for (k, layout) in world.layouts.iter().enumerate().skip(world.first).take(each) {
            let envs = layout.envs;
            let mut shard = Shard::new(layout.clone(), &weights.actor, &weights.critics);
            let states = core::iter::once(&mut shard.actor_state).chain(&mut shard.critic_states);
            for (name, states) in names.iter().zip(states) {
                let rows = gather(states, envs).0;
                let data = file.f32s(&format!("carry.{k}.{name}"), &[rows, envs])?;
                scatter(&data, states, envs);
            }
            shards.push(shard);
        }
        self.set_weights(weights);
        self.learned = learned;
        self.shards = shards;
        self.world = world;
        self.seed = counters[0];
        self.iteration = counters[1];
        self.env_steps = counters[2];
        self.schedule = self.fresh_schedule();
        self.schedule.learning_rate = learning_rate;
        self.schedule.adam_step = counters[3];
        self.schedule.shuffle.seek(counters[4]);
        Ok(())
    }

    /// Takes weights, standard deviations and normalizers only: the start of a next stage. Moments, rates, counters, recurrent
    /// states and a learned reward stay as they are; so do critics that the checkpoint does not have, as that of a policy alone
    /// ([`Checkpoint::of_policy`]). A network with a memory beside its input may begin from one without: its memory stays as it is and
    /// weighs nothing yet. On an error the learner is as before.
    ///
    /// # Errors
    /// If the checkpoint is of another architecture.
    pub fn load_weights(&mut self, checkpoint: &Checkpoint) -> Result<(), CheckpointError> {
        let weights = self.weights_of(checkpoint, false)?;
        self.set_weights(weights);
        Ok(())
    }

    fn set_weights(&mut self, weights: Weights) {
        (self.actor, self.critics) = (weights.actor, weights.critics);
        (self.policy_normalizer, self.critic_normalizer) =
            (weights.policy_normalizer, weights.critic_normalizer);
    }

    /// Copies of the models with the checkpoint's weights, and its normalizers. Unless `all`, critics and a memory may be missing.
    fn weights_of(&self, checkpoint: &Checkpoint, all: bool) -> Result<Weights, CheckpointError> {
        let (mut actor, mut critics) = (self.actor.clone(), self.critics.clone());
        let names: Vec<String> = self.models().into_iter().map(|(name, _)| name).collect();
        for (k, (name, model)) in
            names.iter().zip(core::iter::once(&mut actor).chain(&mut critics)).enumerate()
        {
            let prefix = format!("{name}.");
            let mut tensors = checkpoint.tensors().tensors.iter().filter(|(key, _)| key.starts_with(&prefix));
            // A deeper network's other tensors may all fit.
            if let Some((key, tensor)) =
                tensors.clone().find(|(key, _)| model.layout.find(&key[prefix.len()..]).is_none())
            {
                return Err(CheckpointError::Tensor {
                    path: checkpoint.path().to_owned(),
                    tensor: key.clone(),
                    expected: "none".to_owned(),
                    found: format!("{:?} {:?}", tensor.dtype, tensor.shape),
                });
            }
            let has_memory = tensors.clone().any(|(key, _)| key[prefix.len()..].starts_with("lstm."));
            if k == 0 || all || tensors.next().is_some() {
                model.params = if all || has_memory || !model.net.is_beside() {
                    checkpoint.parameters(name, &model.layout)?
                } else {
                    with_memory(checkpoint, name, model)?
                };
            }
        }
        let policy_normalizer = checkpoint.normalizer("policy", actor.net.input)?;
        let critic_normalizer = if all || checkpoint.has_critic() {
            checkpoint.normalizer("critic", critics[0].net.input)?
        } else {
            self.critic_normalizer.clone()
        };
        Ok(Weights { actor, critics, policy_normalizer, critic_normalizer })
    }
}
