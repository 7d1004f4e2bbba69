//! What it takes to run a policy: observation terms, action decoding, networks, normalizer, files of weights, the contract. No
//! simulator, no motion files, no training.
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
//!
//! What it observes is a list of terms over a few small views. A robot fills the views with its sensors' readings, the simulated
//! task with the engine's state; both call the same functions:
//!
//! ```
//! use paid_lanes::{Mat3, Vec3};
//! use paid_policy::observation::{ObservationId, observe};
//! use paid_policy::{RobotView, Views};
//!
//! let robot = RobotView {
//!     base_rot: Mat3::identity(),
//!     base_ang_vel: Vec3([0.1, 0.0, -0.2]),
//!     joint_pos_rel: &[0.3, -0.4],
//!     joint_vel: &[0.0, 1.0],
//!     last_action: &[0.0, 0.0],
//! };
//! let list = [ObservationId::ProjectedGravity, ObservationId::BaseAngVel, ObservationId::JointPosRel];
//! let mut numbers: Vec<f64> = Vec::new();
//! observe(&list, &Views::of_robot(robot), &mut numbers);
//! assert_eq!(numbers, [0.0, 0.0, -1.0, 0.1, 0.0, -0.2, 0.3, -0.4]);
//! ```

pub mod action;
pub mod bf16;
pub mod checkpoint;
pub mod config;
pub mod contract;
pub mod element;
pub mod env;
mod layout;
pub mod matrix;
pub mod mirror;
pub mod net;
pub mod normalizer;
pub mod observation;
pub mod policy;
pub mod tensor_file;
mod views;

pub use checkpoint::{Checkpoint, CheckpointError};
pub use config::{Activation, LstmConfig, NetworkConfig, NetworkKind};
pub use contract::{Contract, ObservationTerm, PlayContract, WhereItLay};
pub use env::{ObservationGroup, StepBuffers, VecEnv};
pub use layout::{Dimensions, ObservationLayout, ObservationTerms};
pub use mirror::{Mirror, Mirrors, Sides};
pub use policy::{Policy, PolicyState};
pub use tensor_file::TensorFile;
pub use views::{Pose, PrivilegedView, ReferenceView, RobotView, SceneView, Views, projected_gravity};
