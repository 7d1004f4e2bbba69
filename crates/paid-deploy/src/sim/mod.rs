//! A G1 in MuJoCo behind the robot's packets, its senses, its faults, and drills and matches with it.

mod drill;
mod faults;
mod lockstep;
mod matches;
mod robot;
mod senses;
mod serve;

pub use drill::{DrillReport, DrillRow, drill};
pub use faults::Fault;
pub use lockstep::{Lockstep, LockstepOptions};
pub use matches::{KickResult, MatchOptions, MatchResult, play_match};
pub use robot::{Mount, VirtualG1};
pub use senses::{BallSource, DriftingOdometry, NoisyDetector, PoseSource, Senses, TrueState};
pub use serve::{Order, Served, serve};
