//! Networks, PPO, normalizer, checkpoints.
//!
//! Batches are *feature-major*: element (feature `f`, environment `e`) of an `[F, N]` matrix is at `f * N + e`, so that SIMD
//! lanes (environments) are contiguous from the physics to the matrix products.
//!
//! [`Learner`] is the way in: it collects a horizon from shards of environments ([`VecEnv`]) and updates actor and critic.

pub mod adam;
pub mod bench;
pub mod checkpoint;
pub mod config;
pub mod element;
pub mod env;
pub mod gae;
pub mod gaussian;
pub mod learner;
pub mod matrix;
pub mod model;
pub mod net;
pub mod normalizer;
pub mod parallel;
pub mod rollout;
pub mod shard;
pub mod update;
pub mod value_loss;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use config::{ConfigError, LearnConfig, LstmConfig, NetworkConfig, NetworkKind, PpoConfig};
pub use env::{StepBuffers, VecEnv};
pub use learner::{CollectStats, IterationStats, Learner, ShardError};
pub use model::{Model, Policy, PolicyState};
pub use update::UpdateStats;
