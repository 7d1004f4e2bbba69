//! Robot description: the tree, its inertias, joints, actuators and contact shapes, and orders by name.
//!
//! Inside the program bodies and joints are in *model order*: depth-first, a parent before its children, as in the
//! MJCF. Joint `j` moves body `j + 1`; body 0 is the floating base. Other orders exist only where files are
//! read and written, as permutations by name ([`order`]).
//!
//! ```
//! use paid_lanes::{Quat, Vec3};
//! use paid_robot::{RobotModel, RobotSpec, kinematics};
//!
//! let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
//! let control = spec.resolve(&model)?;
//! // Where are the feet in the default pose?
//! let base = Vec3::c([0.0, 0.0, spec.nominal_height_m]);
//! let poses = kinematics::forward(&model, base, Quat::<f64>::identity(), &control.default_pos);
//! for foot in spec.indices(&model)?.feet {
//!     let height = poses[foot].pos.0[2]; // `[m]`
//!     assert!((0.0..0.1).contains(&height), "{}: {height}", model.bodies[foot].name);
//! }
//! # Ok::<(), paid_robot::SpecError>(())
//! ```

pub mod control;
pub mod frames;
pub mod indices;
pub mod kinematics;
pub mod mirror;
pub mod mjcf;
pub mod model;
pub mod names;
pub mod order;
pub mod spec;
pub mod variant;

pub use control::ControlSpec;
pub use frames::{BodyAngVel, WorldAngVel};
pub use indices::RobotIndices;
pub use kinematics::{BodyPose, BodyVelocity};
pub use mirror::MirrorError;
pub use mjcf::{MjcfError, MjcfProblem};
pub use model::{Body, Geom, Joint, RobotModel, Shape};
pub use order::{OrderError, Permutation};
pub use spec::{JointValue, RobotSpec, SpecError};
pub use variant::{Difference, LinkDifference};
