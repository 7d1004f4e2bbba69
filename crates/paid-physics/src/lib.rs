//! Batched rigid-body simulation: one environment a SIMD lane.
//!
//! [`Simulator`] is the view that the task has of any engine; the built-in engine implements it for every lane type,
//! MuJoCo for one-lane `f64`.

pub mod engine;
pub mod scene;
pub mod simulator;

pub use engine::{Engine, EngineSpec, PhysicsError, SolverConstants};
pub use scene::{BallParams, Combine, EnvParams, Material, SceneConfig, Terrain};
pub use simulator::{BallState, BodyState, GroupState, LaneState, Simulator};
