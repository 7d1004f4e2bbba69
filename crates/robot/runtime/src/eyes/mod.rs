//! Onboard perception: a camera's images and an odometry in, estimates of torso and ball out.
//!
//! - [`SensedLink`] brings the reports of perception to the runtime, or those of a virtual robot's senses.
//!
//! The others need the feature `perception`:
//!
//! - `EyesConfig`: where images and points come from.
//! - `TorsoEyes`: a Mid-360's points and samples, or another odometry's poses, to poses of the torso.
//! - `PictureJoiner`: color, depth and camera of one moment together.
//! - `BallEyes`: image to detector to place to ball memory, with the torso's pose of the moment of capture. This is `paid-world`'s
//!   pipeline, the one of `paid eval shooting --eyes`.
//! - `Eyes` (feature `dds`, too): all of it in two threads. A thread of its own follows the odometry, so that no image makes it wait. Its
//!   poses and the other's reports travel in mailboxes: the control threads never wait for either.
//!
//! Times are those of this machine since perception began, in whole nanoseconds. A device's stamps come there by its [`DeviceClock`].

#[cfg(feature = "perception")]
mod ball;
mod clock;
#[cfg(feature = "perception")]
mod config;
#[cfg(feature = "perception")]
mod join;
mod link;
#[cfg(all(feature = "dds", feature = "perception"))]
mod live;
#[cfg(feature = "perception")]
mod torso;

#[cfg(feature = "perception")]
pub use ball::BallEyes;
pub use clock::DeviceClock;
#[cfg(feature = "perception")]
pub use config::{CameraInput, CameraMount, EyesConfig, OdometryInput, StampClock};
#[cfg(feature = "perception")]
pub use join::PictureJoiner;
pub use link::{Desk, Joints, Sensed, SensedLink};
#[cfg(all(feature = "dds", feature = "perception"))]
pub use live::{Eyes, EyesPlace};
#[cfg(feature = "perception")]
pub use torso::{TorsoEyes, TorsoFix};
