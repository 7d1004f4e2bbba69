//! PPO: collection, advantages, gradients, Adam, checkpoints. The networks themselves are `paid-policy`'s.
//!
//! Batches are *feature-major*: element (feature `f`, environment `e`) of an `[F, N]` matrix is at `f * N + e`, so that SIMD
//! lanes (environments) are contiguous from the physics to the matrix products.
//!
//! [`Learner`] is the way in: it collects a horizon from shards of environments ([`VecEnv`]) and updates actor and critic.
//!
//! ```
//! use paid_learn::{LearnConfig, Learner, NetworkConfig, ObservationGroup, StepBuffers, VecEnv};
//!
//! /// Points on a line that the action moves; the reward is higher near the origin.
//! struct Points(Vec<f32>);
//!
//! impl VecEnv for Points {
//!     fn num_envs(&self) -> usize {
//!         self.0.len()
//!     }
//!     fn observation_groups(&self) -> Vec<ObservationGroup> {
//!         ObservationGroup::policy_and_critic(1, 1)
//!     }
//!     fn action_dim(&self) -> usize {
//!         1
//!     }
//!     fn observe(&mut self, groups: &mut [&mut [f32]]) {
//!         for group in groups {
//!             group.copy_from_slice(&self.0);
//!         }
//!     }
//!     fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
//!         for (e, x) in self.0.iter_mut().enumerate() {
//!             *x += 0.1 * actions[e];
//!             out.reward[e] = -*x * *x;
//!         }
//!         out.terminated.fill(0);
//!         out.truncated.fill(0);
//!     }
//! #   fn save(&self) -> Vec<u8> {
//! #       Vec::new()
//! #   }
//! #   fn restore(&mut self, _bytes: &[u8]) -> Result<(), String> {
//! #       Ok(())
//! #   }
//! }
//!
//! let network = NetworkConfig { hidden: vec![16], ..NetworkConfig::default() };
//! let config = LearnConfig { actor: network.clone(), critic: network, ..LearnConfig::default() };
//! let mut learner = Learner::new(1, 1, 1, &config, 7).expect("the configuration is in range");
//! let mut shards = [Box::new(Points(vec![1.0; 16])), Box::new(Points(vec![-1.0; 16]))];
//! let stats = learner.iterate(&mut shards, 2).expect("the shards fit the learner");
//! assert_eq!((stats.iteration, stats.collect.samples), (1, 2 * 16 * config.ppo.horizon));
//! ```

pub mod adam;
mod checkpoint;
pub mod config;
pub mod gae;
pub mod gaussian;
pub mod learned_reward;
pub mod learner;
pub mod model;
pub mod net;
mod operands;
pub mod parallel;
pub mod ranks;
pub mod rollout;
pub mod shard;
pub mod stats;
mod teacher;
pub mod transitions;
pub mod update;
pub mod value_loss;

pub use config::{ConfigError, LearnConfig, MirrorConfig, PpoConfig};
pub use learned_reward::{LearnedReward, RewardRole};
pub use learner::{Learner, ShardError};
pub use model::Model;
pub use ranks::{Alone, Ranks};
pub use stats::{CollectStats, IterationStats, UpdateStats};
pub use teacher::Teacher;
pub use transitions::Transitions;

// What the learner takes and gives, so that its callers need not name two crates.
pub use paid_policy::bf16::Precision;
pub use paid_policy::{
    Checkpoint, CheckpointError, LstmConfig, NetworkConfig, NetworkKind, ObservationGroup, Policy,
    StepBuffers, VecEnv,
};
