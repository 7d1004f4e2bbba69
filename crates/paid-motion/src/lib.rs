//! Motion clips and libraries: the NPZ format, checks, resampling, and what a clip's kick looks like.
//!
//! A [`Clip`] is in *model order* (see [`paid_robot`]); the orders of files are permuted by name on the way in. Every
//! quaternion is w, x, y, z and unit; positions are world metres, velocities per second.

mod clip;
mod error;
#[cfg(test)]
mod file_tests;
mod kick;
mod library;
mod npz;
mod read;
mod resample;
mod rotation;
#[cfg(test)]
mod testing;
mod write;

pub use clip::{Clip, KickLeg};
pub use error::MotionError;
pub use kick::{KickFacts, displacement_in_heading, kick_facts, lowest_point};
pub use library::MotionLibrary;
pub use read::read_clip;
pub use resample::resample;
pub use rotation::{rotation_log, slerp};
pub use write::write_npz;
