//! Onboard perception as one pipeline: images, a LiDAR's scans, inertial samples and joint angles in, the estimate of the ball out.
//!
//! - [`Sight`] runs detector, position, odometry and ball memory. A simulation, a recording and a robot feed it with the same
//!   [`Arrived`] messages, so that what one of them gives is what the others would.
//! - [`Recorder`] and [`Recording`] write and read the messages as MCAP with ROS 2 schemas.
//! - [`ros`] reads and writes the messages of ROS 2's drivers of cameras and LiDARs, and of odometries.
//! - [`fit`] finds the constants of the paper's noise from sightings whose truth is known.
//!
//! ```
//! use paid_world::{Arrived, ImuMessage, Message, Sight, SightSetup};
//!
//! let mut sight = Sight::new(SightSetup::g1()?)?;
//! let imu = ImuMessage { stamp_ns: 5_000_000, gyro: [0.0; 3], accel: [0.0, 0.0, -9.81] };
//! assert!(sight.take(&Arrived { at_ns: 5_100_000, message: Message::Imu(imu) })?.is_none());
//! let step = Arrived { at_ns: 20_000_000, message: Message::Step { to_strike_s: f64::INFINITY } };
//! let estimated = sight.take(&step)?.expect("a step is answered");
//! assert!(estimated.ball.is_none() && estimated.torso.is_none());
//! # Ok::<(), paid_world::SightError>(())
//! ```

mod body;
mod cdr;
mod chunks;
mod error;
pub mod fit;
mod horizon;
mod message;
mod pipeline;
mod pose_watch;
mod reader;
mod recorder;
#[cfg(test)]
mod recorder_tests;
mod replay;
pub mod ros;
mod schema;
mod setup;

pub use body::OwnBody;
pub use error::SightError;
pub use message::{
    Arrived, ImuMessage, JointMessage, Message, PictureMessage, PoseMessage, ScanMessage, seconds,
};
pub use pipeline::{Believed, Sight, Sighted};
pub use pose_watch::{NoPose, OdometryState, PoseFault, PoseWatch};
pub use reader::{Recorded, Recording, decode_any};
pub use recorder::Recorder;
pub use replay::{Replay, fault_kind, replay};
pub use setup::{Finder, SightSetup};
