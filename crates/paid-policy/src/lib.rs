//! What it takes to run a policy: networks, normalizer, files of weights, the contract. No simulator, no motion files, no
//! training.
//!
//! Batches are *feature-major*: element (feature `f`, environment `e`) of an `[F, N]` matrix is at `f * N + e`, so that SIMD
//! lanes (environments) are contiguous from the physics to the matrix products.
//!
//! A policy comes from a file or from bytes, and acts:
//!
//! ```no_run
//! use paid_policy::Checkpoint;
//!
//! let checkpoint = Checkpoint::load("policy.safetensors".as_ref())?;
//! let policy = checkpoint.policy()?;
//! let mut state = policy.start(1);
//! let observation = vec![0.0; policy.obs_dim()];
//! let mut actions = vec![0.0; policy.action_dim()];
//! policy.act(&observation, &mut state, &mut actions);
//! # Ok::<(), paid_policy::CheckpointError>(())
//! ```

pub mod checkpoint;
pub mod config;
pub mod contract;
pub mod element;
pub mod env;
pub mod matrix;
pub mod net;
pub mod normalizer;
pub mod policy;
pub mod tensor_file;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use config::{Activation, LstmConfig, NetworkConfig, NetworkKind};
pub use contract::Contract;
pub use env::{ObservationGroup, StepBuffers, VecEnv};
pub use policy::{Policy, PolicyState};
pub use tensor_file::TensorFile;
