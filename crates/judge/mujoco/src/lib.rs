//! MuJoCo, the reference simulator: policies are trained in the built-in engine and evaluated in MuJoCo.
//!
//! [`mjcf_scene`] writes robot, floor, ball and goal as an MJCF file that MuJoCo and its viewer open. With the feature
//! `mujoco` (default), [`MujocoSim`] runs it behind [`paid_physics::Simulator`], and [`World`] gives safe access to a MuJoCo
//! model with its data for tests and golden values.
//!
//! The library is opened at run time ([`Library`]): nothing is linked or downloaded at build time, one binary serves
//! with and without MuJoCo, and a missing library is an error that names the command that fetches it. (The bindings of
//! the crate `mujoco-rs` 7.0 link at build time: with them the workspace would not build, and the binary not start, where
//! the library is missing.)
//!
//! ```
//! use paid_mujoco::{SceneOptions, mjcf_scene};
//! use paid_physics::{BallParams, SceneConfig};
//! use paid_robot::{RobotModel, RobotSpec};
//!
//! // The scene of `paid eval`, with a ball that bounces and rolls as in training.
//! let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
//! let scene = SceneOptions::default().with_builtin_ball(BallParams::default(), &SceneConfig::default());
//! let xml = mjcf_scene(&model, &spec.resolve(&model)?, &scene);
//! assert!(xml.contains(r#"<geom name="ball" type="sphere" size="0.11""#));
//! # Ok::<(), paid_robot::SpecError>(())
//! ```

pub mod contact;
pub mod ground;
pub mod mjcf;
pub mod scene;

#[cfg(feature = "mujoco")]
mod layout;
#[cfg(feature = "mujoco")]
mod layout_check;
#[cfg(feature = "mujoco")]
pub mod library;
#[cfg(feature = "mujoco")]
pub mod reference;
#[cfg(feature = "mujoco")]
mod reports;
#[cfg(feature = "mujoco")]
pub mod sim;
#[cfg(feature = "mujoco")]
pub mod world;

pub use contact::SpringContact;
pub use ground::Ground;
#[cfg(feature = "mujoco")]
pub use library::{Library, LibraryError, MUJOCO_VERSION};
pub use mjcf::mjcf_scene;
pub use scene::{
    BallOptions, Cone, FloorOptions, FootShapes, GoalMarker, PdControl, SceneOptions, WeakJoint,
};
#[cfg(feature = "mujoco")]
pub use sim::MujocoSim;
#[cfg(feature = "mujoco")]
pub use world::{MujocoError, World};
