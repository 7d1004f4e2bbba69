//! A G1 in MuJoCo behind the robot's packets, its senses, its faults, and drills and matches with it.

#[cfg(feature = "dds")]
mod broadcast;
mod camera;
mod drill;
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
mod vendor;

#[cfg(feature = "dds")]
pub use broadcast::{Broadcast, BroadcastOptions, BroadcastReport};
pub use camera::{Moment, SimCamera};
pub use drill::{DrillReport, DrillRow, drill};
pub use faults::Fault;
pub use lidar::SimLidar;
pub use lockstep::{Lockstep, LockstepOptions};
pub use matches::{MatchOptions, MatchResult, play_match};
pub use own_eyes::{OwnEyes, OwnEyesOptions, TorsoSource};
pub use referee::{Referee, RefereeOptions, Verdict};
pub(crate) use robot::quaternion;
pub use robot::{Mount, STEP_US, VirtualG1};
pub use senses::{BallSource, DriftingOdometry, NoisyDetector, PoseSource, Senses, TrueState};
pub use serve::{Order, ServeOptions, Served, Watcher, serve};
pub use shot::KickResult;
pub use vendor::VendorLink;
