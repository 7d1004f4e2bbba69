//! A reward that the learner itself computes, such as the style reward of adversarial motion priors (AMP), and how it reaches the
//! advantages.

use core::fmt::Debug;

use paid_policy::NetworkConfig;

use crate::ranks::Ranks;
use crate::transitions::Transitions;

/// A reward that is computed from what a horizon collected, and that may learn. It reads the environments' further observation
/// groups ([`paid_policy::VecEnv::observation_groups`]).
///
/// In each iteration [`LearnedReward::reward`] is called once per shard when the shard's horizon is complete, before advantages are
/// estimated; [`LearnedReward::train`] is called once in the update that follows. Results must not depend on the number of threads,
/// and must be the same on every rank.
///
/// ```
/// use paid_learn::{LearnedReward, Ranks, Transitions};
///
/// /// Pays for standing still: minus the distance that the first feature of the group `pose` moved.
/// #[derive(Clone, Debug)]
/// struct Stillness;
///
/// impl LearnedReward for Stillness {
///     fn name(&self) -> &str {
///         "stillness"
///     }
///     fn reward(&self, transitions: &Transitions, reward: &mut [f32]) {
///         let pose = transitions.group("pose").expect("the environment has this group");
///         for t in 0..transitions.steps() {
///             let (before, after) = (transitions.before(pose, t), transitions.after(pose, t));
///             for (e, &done) in transitions.done(t).iter().enumerate() {
///                 // `after` belongs to the next episode where this one ended.
///                 let moved = if done == 0 { (after.row(0)[e] - before.row(0)[e]).abs() } else { 0.0 };
///                 reward[t * transitions.envs() + e] = -moved;
///             }
///         }
///     }
///     fn train(&mut self, _shards: &[&Transitions], _ranks: &dyn Ranks, _threads: usize) {}
///     fn save(&self) -> Vec<u8> {
///         Vec::new()
///     }
///     fn restore(&mut self, _bytes: &[u8]) -> Result<(), String> {
///         Ok(())
///     }
///     fn boxed(&self) -> Box<dyn LearnedReward> {
///         Box::new(self.clone())
///     }
/// }
/// ```
pub trait LearnedReward: Debug + Send + Sync {
    /// A short name; a checkpoint keeps the state under it.
    fn name(&self) -> &str;
    /// Writes the reward of every step of one shard, environment `e` at step `t` at `t * envs + e`. Numbers that are not finite
    /// count as zero.
    fn reward(&self, transitions: &Transitions, reward: &mut [f32]);
    /// Learns from what all shards of all ranks collected in this iteration; `shards` are this rank's, the first ranks have the
    /// first ones. Every rank calls it at the same time, and learns the same.
    fn train(&mut self, shards: &[&Transitions], ranks: &dyn Ranks, threads: usize);
    /// Figures of the last training for a log, by name.
    fn figures(&self) -> Vec<(String, f64)> {
        Vec::new()
    }
    /// Serializes what it has learned, for an exact resume.
    fn save(&self) -> Vec<u8>;
    /// Restores what `save` wrote.
    ///
    /// # Errors
    /// A plain sentence if the bytes do not fit.
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String>;
    /// A copy.
    fn boxed(&self) -> Box<dyn LearnedReward>;
}

/// How a learned reward reaches the advantages.
#[derive(Clone, Debug, PartialEq)]
pub enum RewardRole {
    /// The one critic estimates the weighted sum of both rewards; `task` 0 replaces the task's reward.
    Mixed {
        /// Factor on the task's reward.
        task: f32,
        /// Factor on the learned reward.
        learned: f32,
    },
    /// The learned reward has a critic of its own, which sees the critic's observation. The advantages of both rewards are added
    /// with these weights and then normalized together.
    OwnCritic {
        /// Weight of the advantages of the task's reward.
        task: f32,
        /// Weight of the advantages of the learned reward.
        learned: f32,
        /// The second critic.
        critic: NetworkConfig,
    },
}

impl RewardRole {
    /// Weights of the advantages, one per critic.
    pub fn advantage_weights(&self) -> Vec<f32> {
        match self {
            Self::Mixed { .. } => vec![1.0],
            Self::OwnCritic { task, learned, .. } => vec![*task, *learned],
        }
    }
}

/// A learned reward in a learner.
#[derive(Debug)]
pub struct RewardStream {
    /// The reward.
    pub reward: Box<dyn LearnedReward>,
    /// Its role.
    pub role: RewardRole,
}

impl Clone for RewardStream {
    fn clone(&self) -> Self {
        Self { reward: self.reward.boxed(), role: self.role.clone() }
    }
}
