//! Batched rigid-body simulation: one environment per SIMD lane.
//!
//! [`Simulator`] is the view that the task has of any engine; the built-in engine implements it for every lane type,
//! MuJoCo for one-lane `f64`.
//!
//! ```
//! use paid_physics::{Engine, EngineSpec, SceneConfig, Simulator};
//! use paid_robot::{RobotModel, RobotSpec};
//!
//! // A G1 holds its default pose for 0.2 s; `Engine::<F32x16>` would step sixteen of them at once.
//! let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
//! let control = spec.resolve(&model)?;
//! let scene = SceneConfig::default();
//! let mut engine = Engine::<f64>::new(&model, EngineSpec::for_robot(&model, &spec)?, &scene, 1)?;
//! let mut start = engine.save_lane(0, 0);
//! start.base_pos = [0.0, 0.0, spec.nominal_height_m];
//! start.joint_pos = control.default_pos.clone();
//! engine.reset_lane(0, 0, &start);
//! for _ in 0..10 {
//!     engine.step(0, &control.default_pos);
//! }
//! let height = engine.state(0).bodies[0].pos.0[2]; // `[m]`
//! assert!((height - spec.nominal_height_m).abs() < 0.05);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod compliance;
pub mod contact;
pub mod engine;
pub mod scene;
pub mod segments;
pub mod simulator;

pub use compliance::{Compliance, Cone, ContactCompliance, ContactKind, SoleShape};
pub use contact::{Combine, Material};
pub use engine::{Engine, EngineSpec, PhysicsError, SolverConstants};
pub use scene::{BallParams, EnvParams, MotorScale, SceneConfig, Terrain};
pub use segments::nearest_points;
pub use simulator::{BallState, BodyState, GroupState, LaneState, LateTargets, Simulator};
