//! What can be wrong with human motion and its retargeting.

use core::fmt;
use std::path::PathBuf;

use paid_motion::MotionError;
use paid_robot::SpecError;
use thiserror::Error;

/// An option of a retargeting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    /// The part of the motion.
    Part,
    /// Frame rate of the clip.
    ClipRate,
    /// Height of the human.
    Height,
    /// Begin of the part.
    Begin,
    /// End of the part.
    End,
    /// How much slower the robot moves.
    TimeScale,
    /// Share of the joints' speed limits.
    SpeedShare,
    /// Unit of length of the file.
    Unit,
    /// Frame rate of the file.
    FileRate,
}

impl fmt::Display for Setting {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Part => "part of the motion",
            Self::ClipRate => "frame rate of the clip",
            Self::Height => "height of the human",
            Self::Begin => "begin of the part",
            Self::End => "end of the part",
            Self::TimeScale => "time scale",
            Self::SpeedShare => "share of the speed limits",
            Self::Unit => "unit of length",
            Self::FileRate => "frame rate of the file",
        })
    }
}

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
    /// A robot that is nowhere near the human.
    #[error(
        "{path}: expected a robot within {:.0} mm and {most_rad} rad of the scaled human on average, found {:.1} mm and {angle:.2} rad, \
             {worst:.2} rad at '{bone}': the axes of the bones, --height or --unit are others, or the robot cannot follow",
        1e3 * most_m, 1e3 * distance_m
    )]
    Fit {
        /// The file.
        path: PathBuf,
        /// What is accepted `[m]`.
        most_m: f64,
        /// What is accepted `[rad]`.
        most_rad: f64,
        /// Mean distance over frames and bodies `[m]`.
        distance_m: f64,
        /// Mean angle over frames and bodies `[rad]`.
        angle: f64,
        /// The bone whose part is off most.
        bone: String,
        /// Its mean angle `[rad]`.
        worst: f64,
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
        missing: String,
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
        option: Setting,
        /// What is allowed.
        expected: &'static str,
        /// What was given.
        found: String,
    },
    /// The robot's TOML and MJCF do not fit together.
    #[error(transparent)]
    Spec(#[from] SpecError),
}
