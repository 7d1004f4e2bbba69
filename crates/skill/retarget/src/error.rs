//! What can be wrong with human motion and its retargeting.

use std::path::PathBuf;

use paid_motion::{MotionError, no_other_rate};
use paid_robot::SpecError;
use thiserror::Error;

/// A file of human motion that cannot be used, or a robot that it cannot be brought to.
#[derive(Debug, Error)]
pub enum RetargetError {
    /// The file cannot be read.
    #[error("{path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Something wrong at a place of a text.
    #[error("{path}:{line}:{column}: expected {expected}, found {found}")]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Character of the line, from 1.
        column: usize,
        /// What the format asks for.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A description of a skeleton that does not fit its points.
    #[error("{path}: {place}: expected {expected}, found {found}")]
    Points {
        /// The description, or the points.
        path: PathBuf,
        /// Key or part.
        place: String,
        /// What is needed.
        expected: String,
        /// What is there.
        found: String,
    },
    /// Another frame rate than the file's own.
    #[error("{path}: expected {}, found --fps {given}", no_other_rate(format_args!("{stated:.1}")))]
    Rate {
        /// The file.
        path: PathBuf,
        /// The file's own `[Hz]`.
        stated: f64,
        /// The one in the options `[Hz]`.
        given: f64,
    },
    /// Points that cannot be read.
    #[error(transparent)]
    Motion(#[from] MotionError),
    /// A text that is no motion of a few seconds.
    #[error(
        "{path}: expected at most {} MiB of text, found {} MiB; cut the seconds around the kick out of the file before: --from and \
             --to choose a part of what was read",
        most >> 20, found.div_ceil(1 << 20)
    )]
    Large {
        /// The file.
        path: PathBuf,
        /// What is read `[bytes]`.
        most: u64,
        /// The file's size `[bytes]`.
        found: u64,
    },
    /// Too few frames for any motion.
    #[error("{path}: expected at least {least} s of motion, found {frames} frames at {fps:.0} Hz")]
    Short {
        /// The file.
        path: PathBuf,
        /// What is needed `[s]`.
        least: f64,
        /// Frames of the file.
        frames: usize,
        /// Its rate `[Hz]`.
        fps: f64,
    },
    /// A player who does not stand.
    #[error(
        "{path}: expected a player on the feet, found a trunk that is {degrees:.0} degrees off upright on average: lying, or \
             the file's up axis is another"
    )]
    Lying {
        /// The file.
        path: PathBuf,
        /// Mean angle of the trunk from upright.
        degrees: f64,
    },
    /// A file name that no format goes with.
    #[error(
        "{path}: expected human motion: a name that ends in .bvh or .amc, or an .npz with the key 'positions'"
    )]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// AMC holds angles only; the bones are in another file.
    #[error(
        "{path}: expected the skeleton of this motion (.asf of an .amc, .toml of points) beside it or named, found {found}"
    )]
    Skeleton {
        /// The motion.
        path: PathBuf,
        /// What was found instead.
        found: String,
    },
    /// A skeleton beside a BVH file.
    #[error("{path}: expected no --skeleton beside a BVH file, which has its own, found --skeleton {given}")]
    OwnSkeleton {
        /// The motion.
        path: PathBuf,
        /// The skeleton that was named.
        given: PathBuf,
    },
    /// Bones whose names no table knows.
    #[error("{path}: bones named as in {naming}: '{missing}' is missing; found: {found}")]
    Bones {
        /// The file.
        path: PathBuf,
        /// The nearest known naming.
        naming: &'static str,
        /// The first missing bone.
        missing: &'static str,
        /// The bones that are there.
        found: String,
    },
    /// The table names what the robot does not have.
    #[error("retargeting to '{robot}': the robot has no {kind} '{name}'; tables exist for g1")]
    Robot {
        /// The robot.
        robot: String,
        /// Body or joint.
        kind: &'static str,
        /// The missing name.
        name: String,
    },
    /// An option out of range.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// The option.
        option: &'static str,
        /// What is allowed.
        expected: &'static str,
        /// What was given.
        found: String,
    },
    /// The robot's TOML and MJCF do not fit together.
    #[error(transparent)]
    Spec(#[from] SpecError),
}
