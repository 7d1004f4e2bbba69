//! Onboard perception: a camera's images and an odometry in, estimates of torso and ball out.
//!
//! - [`EyesConfig`]: where images and points come from.
//! - [`TorsoEyes`]: a Mid-360's points and samples, or another odometry's poses, to poses of the torso.
//! - [`PictureJoiner`]: color, depth and camera of one moment together.
//! - [`BallEyes`]: image to detector to place to ball memory, with the torso's pose of the moment of capture. This is `paid-world`'s
//!   pipeline, the one of `paid eval shooting --eyes`.
//! - `Eyes` (feature `dds`): all of it in two threads, and [`SensedLink`], which brings their reports to the runtime. A thread of its own
//!   follows the odometry, so that no image makes it wait. Its poses and the other's reports travel in mailboxes: the control threads
//!   never wait for either.
//!
//! Times are those of this machine since perception began, in whole nanoseconds. A device's stamps come there by its [`DeviceClock`].

mod ball;
mod clock;
mod config;
mod join;
mod link;
#[cfg(feature = "dds")]
mod live;
mod torso;

pub use ball::BallEyes;
pub use clock::DeviceClock;
pub use config::{CameraInput, CameraMount, EyesConfig, OdometryInput, StampClock};
pub use join::PictureJoiner;
pub use link::{Desk, Sensed, SensedLink};
#[cfg(feature = "dds")]
pub use live::{Eyes, EyesPlace};
pub use torso::{TorsoEyes, TorsoFix};
