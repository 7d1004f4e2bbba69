//! Motion clips and libraries: the NPZ and CSV formats, GMR's pickle, checks, resampling, what a clip's kick looks like, and kicks made from
//! scratch.
//!
//! A [`Clip`] is in *model order* (see [`paid_robot`]); the orders of files are permuted by name on the way in. Every
//! quaternion is w, x, y, z and unit; positions are world meters, velocities per second.
//!
//! The kicks that the program generates, at 50 frames per second:
//!
//! ```
//! use paid_motion::MotionLibrary;
//! use paid_robot::{RobotModel, RobotSpec};
//!
//! let kicks = MotionLibrary::builtin(&RobotModel::g1(), &RobotSpec::g1(), 50.0)?;
//! let kick = &kicks.clips[0];
//! assert_eq!((kicks.clips.len(), kick.joints, kick.fps), (13, 29, 50.0));
//! assert_eq!(kick.joint_pos.len(), kick.frames * kick.joints);
//! # Ok::<(), paid_motion::MotionError>(())
//! ```

mod balance;
pub mod check;
pub mod clean;
mod clip;
mod columns;
mod csv;
#[cfg(test)]
mod csv_tests;
pub mod edit;
mod error;
#[cfg(test)]
mod file_tests;
mod foreign;
mod format;
pub mod generate;
mod gmr;
#[cfg(test)]
mod gmr_tests;
mod implausible;
mod kick;
mod label;
mod library;
#[cfg(test)]
mod mutation_tests;
mod npz;
mod pickle;
mod points;
mod poses;
mod quat_order;
mod read;
mod resample;
mod rotation;
#[cfg(test)]
mod testing;
mod write;

pub use balance::{Balance, GRAVITY, balance, hull, support_margin};
pub use clip::{Clip, KickLeg};
pub use csv::{parse_csv, read_csv, write_csv};
pub use error::MotionError;
pub use foreign::refuse_git_lfs;
pub use format::{EXTENSIONS, JointOrder, ReadOptions, read_motion, write_motion};
pub use gmr::{parse_gmr, read_gmr};
pub use kick::{KickFacts, ball_ahead, displacement_in_heading, kick_facts, lowest_point};
pub use label::{KickLabel, fastest_kick};
pub use library::{MotionLibrary, motion_files};
pub use points::{Points, is_points_file, parse_points, read_points, write_points};
pub use quat_order::QuatOrder;
pub use read::{parse_npz, read_clip};
pub use resample::resample;
pub use rotation::{rotation_log, slerp};
pub use write::write_npz;
