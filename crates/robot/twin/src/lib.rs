//! A simulated G1 on the robot's DDS topics: it cannot break.
//!
//! - [`VirtualG1`]: MuJoCo behind the packets of `paid_runtime`; [`serve`] runs it on a real clock behind any link.
//! - [`Lockstep`]: robot, senses, link, runtime and writer in simulated time; the same seed gives the same run bit for bit.
//! - [`play_match`]: kick after kick; [`drill`]: [`Fault`] after fault, and how soon the robot is damped.
//! - [`OwnEyes`]: a rendered camera and a simulated Mid-360 in place of senses that use the ground truth.
//! - [`draw_course`]: a log's replay as a chart.
//!
//! Begin reading with `robot.rs`, then `lockstep.rs`.

#[cfg(feature = "dds")]
mod broadcast;
mod camera;
mod course;
mod drill;
mod error;
mod faults;
mod lidar;
mod lockstep;
mod matches;
mod own_eyes;
mod referee;
mod robot;
mod senses;
mod serve;
mod shot;
mod task;
mod vendor;

#[cfg(feature = "dds")]
pub use broadcast::{Broadcast, BroadcastOptions, BroadcastReport};
pub use camera::{Moment, SimCamera};
pub use course::draw_course;
pub use drill::{DrillReport, DrillRow, drill};
pub use error::TwinError;
pub use faults::Fault;
pub use lidar::SimLidar;
pub use lockstep::{Lockstep, LockstepOptions};
pub use matches::{MatchOptions, MatchResult, play_match};
pub use own_eyes::{OwnEyes, OwnEyesOptions, TorsoSource};
pub use referee::{Referee, RefereeOptions, Verdict};
pub use robot::{Mount, STEP_US, VirtualG1};
pub use senses::{BallSource, DriftingOdometry, NoisyDetector, PoseSource, Senses, TrueState};
pub use serve::{Order, ServeOptions, Served, Watcher, serve};
pub use shot::KickResult;
pub use task::trained_task;
pub use vendor::VendorLink;
