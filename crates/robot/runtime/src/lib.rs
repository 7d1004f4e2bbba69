//! A policy on the robot.
//!
//! - [`wire`]: the messages of a Unitree G1, byte for byte, with their checksum.
//! - [`Link`]: how packets travel; [`ChannelLink`] within a process, and with the feature `dds` the robot's own network.
//! - [`Runtime`]: packets in, a command out. No threads and no clock: the same packets give the same commands bit for bit.
//! - [`Writer`]: the last hand before the robot, which damps if the runtime is silent.
//! - [`switcher`]: who is in command of the robot, and the release of the vendor's controller.
//! - [`eyes`]: the robot's camera and LiDAR (feature `perception`); `ros` (`dds` too): their topics.
//! - `view` (feature `view`): the runtime on a terminal.
//!
//! What the policy observes comes from [`paid_policy`], where the ball is from [`paid_track`]: the code of training and evaluation.
//!
//! ```
//! use paid_runtime::wire::LowCmd;
//!
//! // The command to a damped G1, 500 times a second.
//! let command = LowCmd::damping(5, 29, 3.0);
//! assert_eq!(command.to_cdr().len(), LowCmd::CDR_SIZE);
//! assert_eq!(command.crc, command.expected_crc());
//! ```

mod check;
mod cpu;
#[cfg(feature = "dds")]
mod dds;
mod error;
pub mod eyes;
#[cfg(feature = "dds")]
mod interface;
mod lateness;
mod limits;
mod link;
mod live;
pub mod log;
mod machine;
mod mailbox;
mod message;
mod motors;
mod pause;
mod player;
#[cfg(feature = "dds")]
mod published;
#[cfg(feature = "dds")]
mod raw;
#[cfg(all(feature = "dds", feature = "perception"))]
pub mod ros;
pub mod runtime;
#[cfg(feature = "dds")]
mod state_topic;
pub mod switcher;
#[cfg(feature = "view")]
pub mod view;
pub mod wire;
mod writer;

pub use check::{CheckReport, Checker};
pub use cpu::Usage;
#[cfg(feature = "dds")]
pub use dds::{DdsLink, Side};
pub use error::DeployError;
pub use lateness::{BareTimer, Durations, LATENESS_EDGES_MS, Lateness, LatenessFigures, lateness_table};
pub use limits::{Envelope, Limits};
pub use link::{ChannelLink, Inlet, Link, LinkError, Outlet};
pub use live::{LastWords, Live, LiveReport, LiveStatus, Told, TypedKeys, run_live};
pub use mailbox::Mailbox;
pub use message::{BallDetection, BallReport, EyesReport, OdometryPose, Packet, TorsoPose, quaternion};
pub use motors::{G1_MOTORS, motors_of};
pub use player::{Player, PlayerSpec};
pub use runtime::{
    Event, JointStatus, Latency, LatencyFigures, Output, Phase, PolicyTrace, Reason, Runtime, State, Status,
};
#[cfg(feature = "dds")]
pub use state_topic::StateTopic;
pub use writer::Writer;
