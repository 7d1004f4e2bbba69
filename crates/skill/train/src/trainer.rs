//! Learner, shards and sampler together: one iteration after another, saved and restored exactly.

use std::borrow::Cow;
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

use paid_amp::StyleReward;
use paid_learn::{Alone, Checkpoint, Learner, Ranks, Teacher};
use paid_play::PRESET_FILE;
use paid_policy::observation::ObservationId;
use paid_task::{BallCurriculum, SamplerState, TaskMetrics, TaskShard, TrainShard};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::inputs::inputs_from;
use crate::memory::check_rollouts;
use crate::progress::{Progress, describe};
use crate::{LossRecord, Record, RunPreset, TrainError};

/// A stage in training, on shards of the task or, in tests, of another kind.
pub struct Trainer<E: ?Sized = dyn TaskShard> {
    preset: RunPreset,
    motions: Vec<String>,
    learner: Learner,
    shards: Vec<Box<E>>,
    sampler: SamplerState,
    ball_curriculum: BallCurriculum,
    progress: Progress,
    ranks: Arc<dyn Ranks>,
}

/// What a shard counted in an iteration, and where its episodes failed.
#[derive(Clone, Serialize, Deserialize)]
struct Counts(TaskMetrics, Vec<f32>);

/// What a checkpoint holds in addition to the learner's tensors and the shards' states.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Meta {
    stage: String,
    progress: Progress,
    shards: usize,
    motions: Vec<String>,
    /// How far the balls have spread.
    spread: f32,
}

impl Meta {
    fn of(checkpoint: &Checkpoint) -> Result<Self, TrainError> {
        serde_json::from_slice(blob(checkpoint, META)?)
            .map_err(|error| damaged(checkpoint, format!("{META}: {error}")))
    }
}

/// The counters in a full checkpoint.
///
/// # Errors
/// If it is not a full one.
pub fn progress_of(checkpoint: &Checkpoint) -> Result<Progress, TrainError> {
    Ok(Meta::of(checkpoint)?.progress)
}

fn damaged(checkpoint: &Checkpoint, message: String) -> TrainError {
    TrainError::Checkpoint { path: checkpoint.path().to_owned(), message }
}

fn blob<'a>(checkpoint: &'a Checkpoint, name: &str) -> Result<&'a [u8], TrainError> {
    let missing =
        || damaged(checkpoint, format!("expected an entry '{name}' (a full checkpoint), found none"));
    checkpoint.blob(name).ok_or_else(missing)
}

const META: &str = "trainer.json";
const SAMPLER: &str = "sampler";
const SHARD: &str = "shard.";

impl<E: TrainShard + ?Sized> Trainer<E> {
    /// A trainer with fresh networks.
    ///
    /// # Errors
    /// If there is no shard, the learner cannot be built for these, or the rollouts do not fit in memory.
    pub fn new(preset: &RunPreset, shards: Vec<Box<E>>, motions: Vec<String>) -> Result<Self, TrainError> {
        let Some(first) = shards.first() else {
            return Err(TrainError::Setup("expected at least one shard, found none".to_owned()));
        };
        let dims = [first.policy_obs_dim(), first.critic_obs_dim(), first.action_dim()];
        let envs = shards.iter().map(|shard| shard.num_envs()).sum();
        check_rollouts(envs, preset.learn.ppo.horizon, dims).map_err(TrainError::Setup)?;
        let sampler = first.new_sampler();
        let mut learner = Learner::new(dims[0], dims[1], dims[2], &preset.learn, preset.run.seed)
            .map_err(|error| TrainError::Setup(error.to_string()))?;
        if preset.learn.ppo.mirror.weight > 0.0 {
            let mirrors =
                first.mirrors().map_err(|why| TrainError::Setup(format!("learn.ppo.mirror: {why}")))?;
            learner = learner.with_mirrors(mirrors).map_err(|error| TrainError::Setup(error.to_string()))?;
        }
        Ok(Self {
            preset: preset.clone(),
            motions,
            learner,
            shards,
            sampler,
            ball_curriculum: BallCurriculum::default(),
            progress: Progress::default(),
            ranks: Arc::new(Alone),
        })
    }

    /// The same trainer as one of several processes: its shards are a part of all, those of the first ranks first.
    #[must_use]
    pub fn with_ranks(mut self, ranks: Arc<dyn Ranks>) -> Self {
        self.learner = self.learner.with_ranks(Arc::clone(&ranks));
        self.ranks = ranks;
        self
    }

    /// The same trainer with a style reward, in the role that the preset's `amp` gives it.
    ///
    /// # Errors
    /// If the preset has none, or a factor is not finite.
    pub fn with_style(mut self, style: StyleReward) -> Result<Self, TrainError> {
        let Some(amp) = &self.preset.amp else {
            return Err(TrainError::Setup("expected [amp] in the preset, found none".to_owned()));
        };
        let role = self.preset.style_role(amp);
        self.learner = self
            .learner
            .with_learned_reward(Box::new(style), role)
            .map_err(|error| TrainError::Setup(error.to_string()))?;
        Ok(self)
    }

    /// The same trainer with a policy to imitate, which its shards must show what it sees.
    ///
    /// # Errors
    /// If it takes other actions.
    pub fn with_teacher(mut self, teacher: Teacher) -> Result<Self, TrainError> {
        self.learner =
            self.learner.with_teacher(teacher).map_err(|error| TrainError::Setup(error.to_string()))?;
        Ok(self)
    }

    /// Counters.
    pub fn progress(&self) -> &Progress {
        &self.progress
    }

    /// The learner.
    pub fn learner(&self) -> &Learner {
        &self.learner
    }

    /// The shards, for measuring them alone.
    pub fn shards_mut(&mut self) -> &mut [Box<E>] {
        &mut self.shards
    }

    /// Environments over this rank's shards.
    pub fn num_envs(&self) -> usize {
        self.shards.iter().map(|shard| shard.num_envs()).sum()
    }

    /// Notes which share of the run is over (0 to 1); the learner's noise may depend on it.
    pub fn anneal(&mut self, share: f64) {
        self.progress.share = share;
        self.learner.anneal(share);
    }

    /// One rollout, one update, one update of the sampler.
    ///
    /// # Errors
    /// If a shard does not fit the learner.
    pub fn iterate(&mut self, threads: usize) -> Result<Record, TrainError> {
        let start = Instant::now();
        let stats = self
            .learner
            .iterate(&mut self.shards, threads)
            .map_err(|error| TrainError::Setup(error.to_string()))?;
        let metrics = self.merge_shards()?;
        let elapsed = start.elapsed().as_secs_f64();
        let progress = &mut self.progress;
        progress.iteration += 1;
        progress.samples += stats.collect.samples as u64;
        progress.elapsed_s += elapsed;
        progress.add_episodes(&metrics);
        let (mean_reward, mean_episode_length) = progress.episode_means();
        let mut record = Record {
            stage: self.preset.stage.clone(),
            iteration: progress.iteration,
            iterations: self.preset.run.iterations,
            samples: progress.samples,
            products: self.learner.products().to_owned(),
            elapsed_s: progress.elapsed_s,
            samples_per_s: stats.collect.samples as f64 / elapsed,
            collect_s: stats.collect.wall_s,
            learn_s: stats.learn_s,
            mean_reward,
            mean_episode_length,
            loss: LossRecord {
                value_function: stats.update.value_loss,
                surrogate: stats.update.surrogate_loss,
                entropy: stats.entropy,
                learning_rate: stats.learning_rate,
                mirror: stats.update.mirror_loss,
                teacher: stats.update.teacher_loss,
                kl: stats.update.kl,
                gradient_norm: stats.update.grad_norm,
            },
            mean_noise_std: stats.mean_std,
            nan_samples: stats.collect.non_finite,
            nan_minibatches: stats.update.skipped,
            ..Record::default()
        };
        describe(&metrics, self.preset.task.control_dt_s(), &mut record);
        if self.preset.task.scene.ball {
            record.metrics.push("kick/reach", self.ball_curriculum.reach(&self.preset.task.ball));
        }
        for (network, gates) in self.learner.gates() {
            record.metrics.push(format!("gates/{network}_saturated"), gates.saturated);
            record.metrics.push(format!("gates/{network}_weight_rms"), gates.weight_rms);
        }
        if let Some(reward) = self.learner.learned_reward() {
            record.metrics.push(format!("{}/reward", reward.name()), stats.collect.mean_learned_reward);
            for (figure, value) in reward.figures() {
                record.metrics.push(format!("{}/{figure}", reward.name()), value);
            }
        }
        Ok(record)
    }

    /// Takes the shards' counts in the order of the shards and hands the new distribution to all of them.
    fn merge_shards(&mut self) -> Result<TaskMetrics, TrainError> {
        let mut metrics = TaskMetrics::default();
        let mut failures = vec![0.0; self.sampler.failures.len()];
        let own: Vec<Counts> =
            self.shards.iter_mut().map(|shard| Counts(shard.take_metrics(), shard.take_failures())).collect();
        for Counts(counted, failed) in self.of_all(&own)? {
            metrics.merge(&counted);
            for (sum, count) in failures.iter_mut().zip(failed) {
                *sum += count;
            }
        }
        self.sampler.update(&failures, &self.preset.task.sampling);
        if metrics.kick.episodes > 0 {
            self.ball_curriculum.advance(metrics.kick.on_target_share(), &self.preset.task.ball);
        }
        for shard in &mut self.shards {
            shard.set_sampler(&self.sampler);
            shard.set_ball_curriculum(self.ball_curriculum);
        }
        Ok(metrics)
    }

    /// Every rank's items, in the order of all shards.
    fn of_all<T: Clone + Serialize + DeserializeOwned>(&self, own: &[T]) -> Result<Vec<T>, TrainError> {
        if self.ranks.count() == 1 {
            return Ok(own.to_vec());
        }
        let broken = |error: postcard::Error| TrainError::Setup(format!("ranks: {error}"));
        let bytes = postcard::to_allocvec(own).map_err(broken)?;
        let mut all = Vec::new();
        for part in self.ranks.gather(&bytes) {
            all.extend(postcard::from_bytes::<Vec<T>>(&part).map_err(broken)?);
        }
        Ok(all)
    }

    /// Writes everything that the next iteration depends on to one file; an older file stays whole if this fails. Every rank must call it;
    /// the first one writes.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), TrainError> {
        let own: Vec<Vec<u8>> = self.shards.iter().map(|shard| shard.save()).collect();
        let states = self.of_all(&own)?;
        let meta = Meta {
            stage: self.preset.stage.clone(),
            progress: self.progress.clone(),
            shards: states.len(),
            motions: self.motions.clone(),
            spread: self.ball_curriculum.progress,
        };
        let meta = serde_json::to_vec(&meta)
            .map_err(|error| TrainError::Checkpoint { path: path.to_owned(), message: error.to_string() })?;
        let preset = self.preset.to_toml()?;
        let failures: Vec<u8> = self.sampler.failures.iter().flat_map(|x| x.to_le_bytes()).collect();
        let states: Vec<(String, Vec<u8>)> =
            states.into_iter().enumerate().map(|(k, state)| (format!("{SHARD}{k}"), state)).collect();
        let mut blobs: Vec<(&str, &[u8])> =
            vec![(META, &meta), (PRESET_FILE, preset.as_bytes()), (SAMPLER, &failures)];
        blobs.extend(states.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice())));
        Ok(self.learner.save(path, &blobs)?)
    }

    /// Writes networks, normalizers and preset alone: what an evaluation needs. Nothing of the trainer changes.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save_policy(&self, path: &Path) -> Result<(), TrainError> {
        let preset = self.preset.to_toml()?;
        Ok(self.learner.save_policy(path, &[(PRESET_FILE, preset.as_bytes())])?)
    }

    /// Continues exactly where a checkpoint of the same run, in the same phase, stopped.
    ///
    /// # Errors
    /// If it is no full checkpoint, of other networks, shards or motions, or of a preset that differs in what holds for a whole run.
    pub fn resume(&mut self, checkpoint: &Checkpoint) -> Result<(), TrainError> {
        // If only an earlier version can read it, the run folder's has been brought up to date by hand.
        if let Ok(found) = RunPreset::of_checkpoint(checkpoint) {
            self.preset.check_same_run(&found).map_err(|error| damaged(checkpoint, error.to_string()))?;
        }
        self.restore(checkpoint)?;
        let first = self.shards.len() * self.ranks.rank();
        for (k, shard) in self.shards.iter_mut().enumerate() {
            let name = format!("{SHARD}{}", first + k);
            let state = blob(checkpoint, &name)?;
            shard.restore(state).map_err(|error| damaged(checkpoint, format!("{name}: {error}")))?;
        }
        Ok(())
    }

    /// Continues in phase `phase` from a checkpoint of the same run in another one: learner, sampler and counters are as they were, the
    /// environments begin new episodes, because their states may hold other things in another phase.
    ///
    /// # Errors
    /// If it is no full checkpoint, or of other networks, shards or motions.
    pub fn next_phase(&mut self, checkpoint: &Checkpoint, phase: usize) -> Result<(), TrainError> {
        self.restore(checkpoint)?;
        self.learner.forget();
        self.progress.phase = phase;
        for shard in &mut self.shards {
            shard.set_sampler(&self.sampler);
            shard.set_ball_curriculum(self.ball_curriculum);
        }
        Ok(())
    }

    /// Takes learner, sampler and counters of a checkpoint, once all of them are known to fit.
    fn restore(&mut self, checkpoint: &Checkpoint) -> Result<(), TrainError> {
        let meta = self.meta_of(checkpoint)?;
        let failures = self.failures_of(checkpoint)?;
        self.learner.restore(checkpoint)?;
        self.sampler.failures = failures;
        self.ball_curriculum.progress = meta.spread;
        self.progress = meta.progress;
        Ok(())
    }

    fn meta_of(&self, checkpoint: &Checkpoint) -> Result<Meta, TrainError> {
        let meta = Meta::of(checkpoint)?;
        let shards = self.shards.len() * self.ranks.count();
        if meta.shards != shards {
            let message = format!("run.shards: expected {shards}, found {}", meta.shards);
            return Err(damaged(checkpoint, message));
        }
        if meta.motions != self.motions {
            let (expected, found) = (self.motions.join(", "), meta.motions.join(", "));
            return Err(damaged(checkpoint, format!("motions: expected {expected}, found {found}")));
        }
        Ok(meta)
    }

    fn failures_of(&self, checkpoint: &Checkpoint) -> Result<Vec<f32>, TrainError> {
        let failures: Vec<f32> = blob(checkpoint, SAMPLER)?
            .chunks_exact(4)
            .map(|chunk| f32::from_le_bytes([chunk[0], chunk[1], chunk[2], chunk[3]]))
            .collect();
        let expected = self.sampler.failures.len();
        if failures.len() != expected || failures.iter().any(|x| !x.is_finite()) {
            let message = format!("{SAMPLER}: expected {expected} finite numbers, found others");
            return Err(damaged(checkpoint, message));
        }
        Ok(failures)
    }

    /// Takes the networks and normalizers of a checkpoint, as Stage II does of Stage I. Counters, optimizer and environments
    /// stay fresh. So does the noise where the ball or the critic is new, unless `learn.ppo.keep_std`: a policy that has learned to
    /// follow motions ends with little, and does not find the strike with it. Terms that policy or critic observe in another order than
    /// the checkpoint's keep their weights. A policy that observes more of them begins with weights of zero for the new ones. A network
    /// with a memory beside its input begins as the one without that the checkpoint may hold.
    ///
    /// # Errors
    /// If it holds no preset, is of other networks or of terms that do not belong to these, or holds no critic where no teacher holds the policy
    /// until a new one has learned.
    pub fn start_from(&mut self, checkpoint: &Checkpoint) -> Result<(), TrainError> {
        let before = RunPreset::of_checkpoint(checkpoint)?;
        let (saw, see) = (&before.task.observations, &self.preset.task.observations);
        let meta = checkpoint.meta();
        let inputs = |key: &str, saw: &[ObservationId], see: &[ObservationId], size: usize| {
            inputs_from(saw, see, meta.actions, size)
                .map_err(|message| damaged(checkpoint, format!("task.observations.{key}: {message}")))
        };
        let policy = inputs("policy", &saw.policy, &see.policy, meta.policy_obs)?;
        let has_critic = checkpoint.has_critic();
        let critic = match &self.preset.teacher {
            _ if has_critic => inputs("critic", &saw.critic, &see.critic, meta.critic_obs)?,
            Some(_) => None,
            None => {
                let message = "expected a critic, or a [teacher] in the preset, found neither";
                return Err(damaged(checkpoint, message.to_owned()));
            }
        };
        let mut weights = Cow::Borrowed(checkpoint);
        if let Some(from) = policy {
            weights = Cow::Owned(weights.with_policy_inputs(&from)?);
        }
        // A critic of more terms is one of other networks.
        if let Some(from) = critic.filter(|from| from.len() == meta.critic_obs) {
            weights = Cow::Owned(weights.with_critic_inputs(&from)?);
        }
        self.learner.load_weights(&weights)?;
        let ppo = &self.preset.learn.ppo;
        let is_new = !has_critic || self.preset.task.scene.ball && !before.task.scene.ball;
        if is_new && !ppo.keep_std {
            let std = ppo.initial_std;
            self.learner.set_std(std).map_err(|error| TrainError::Setup(error.to_string()))?;
        }
        Ok(())
    }
}
