//! Robot description: the tree, its inertias, joints, actuators and contact shapes, and orders by name.
//!
//! Inside the program bodies and joints are in *model order*: depth-first, a parent before its children, as in the
//! MJCF. Joint `j` moves body `j + 1`; body 0 is the floating base. Other orders exist only at file borders, as
//! permutations by name ([`order`]).

pub mod control;
pub mod frames;
pub mod indices;
pub mod kinematics;
pub mod mjcf;
pub mod model;
pub mod names;
pub mod order;
pub mod spec;

pub use control::ControlSpec;
pub use frames::{BodyAngVel, WorldAngVel};
pub use indices::RobotIndices;
pub use kinematics::{BodyPose, BodyVelocity};
pub use mjcf::{MjcfError, MjcfProblem};
pub use model::{Body, Geom, Joint, RobotModel, Shape};
pub use order::{OrderError, Permutation};
pub use spec::{JointValue, RobotSpec, SpecError};
