//! Batched rigid-body simulation: one environment a SIMD lane.
//!
//! [`Simulator`] is the view that the task has of any engine; the built-in engine implements it for every lane type,
//! MuJoCo for one-lane `f64`.

pub mod contact;
pub mod engine;
pub mod scene;
pub mod simulator;

pub use contact::{Combine, Material};
pub use engine::{Engine, EngineSpec, PhysicsError, SolverConstants};
pub use scene::{BallParams, EnvParams, SceneConfig, Terrain};
pub use simulator::{BallState, BodyState, GroupState, LaneState, Simulator};
