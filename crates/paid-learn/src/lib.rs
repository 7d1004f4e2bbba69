//! PPO: collection, advantages, gradients, Adam, checkpoints. The networks themselves are `paid-policy`'s.
//!
//! Batches are *feature-major*: element (feature `f`, environment `e`) of an `[F, N]` matrix is at `f * N + e`, so that SIMD
//! lanes (environments) are contiguous from the physics to the matrix products.
//!
//! [`Learner`] is the way in: it collects a horizon from shards of environments ([`VecEnv`]) and updates actor and critic.

pub mod adam;
pub mod bench;
mod checkpoint;
pub mod config;
pub mod gae;
pub mod gaussian;
pub mod learned_reward;
pub mod learner;
pub mod model;
pub mod net;
pub mod parallel;
pub mod rollout;
pub mod shard;
pub mod transitions;
pub mod update;
pub mod value_loss;

pub use config::{ConfigError, LearnConfig, PpoConfig};
pub use learned_reward::{LearnedReward, RewardRole};
pub use learner::{CollectStats, IterationStats, Learner, ShardError};
pub use model::Model;
pub use transitions::Transitions;
pub use update::UpdateStats;

// What the learner takes and gives, so that its callers need not name two crates.
pub use paid_policy::{
    Checkpoint, CheckpointError, LstmConfig, NetworkConfig, NetworkKind, ObservationGroup, Policy,
    StepBuffers, VecEnv,
};
