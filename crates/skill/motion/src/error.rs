//! What can be wrong with a motion file or folder.

use std::path::PathBuf;

use paid_robot::{OrderError, SpecError};
use thiserror::Error;

use crate::generate::GenerateError;

/// A motion file or folder that cannot be used; always names the path.
#[derive(Debug, Error)]
pub enum MotionError {
    /// The folder or file cannot be read or written.
    #[error("{path}: {source}")]
    Io {
        /// File or folder.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// The folder holds no motion.
    #[error("{path}: expected a folder with motion files (*.npz, *.csv, *.pkl), found none")]
    Empty {
        /// The folder.
        path: PathBuf,
    },
    /// The file is not a whole NPZ archive.
    #[error("{path}: expected an NPZ archive (a zip file of arrays), found: {problem}")]
    Archive {
        /// The file.
        path: PathBuf,
        /// The zip reader's error.
        problem: String,
    },
    /// A key is missing.
    #[error("{path}: key '{key}' is missing; found: {found}")]
    MissingKey {
        /// The file.
        path: PathBuf,
        /// The missing key.
        key: &'static str,
        /// The keys that are there.
        found: String,
    },
    /// A key has the wrong type, shape or values.
    #[error("{path}: key '{key}': expected {expected}, found {found}")]
    Key {
        /// The file.
        path: PathBuf,
        /// The key.
        key: &'static str,
        /// What the format requires.
        expected: String,
        /// What is there, with its place.
        found: String,
    },
    /// The names of joints or bodies do not match the robot's.
    #[error("{path}: {list}: {source}")]
    Order {
        /// The file.
        path: PathBuf,
        /// Which list of names.
        list: &'static str,
        /// What does not match.
        source: OrderError,
    },
    /// A text file with something wrong in a line.
    #[error("{path}:{line}:{column}: expected {expected}, found {found}")]
    Text {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Field of the line, from 1.
        column: usize,
        /// What the format requires.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A pickle that is none, or that holds other things than numbers.
    #[error("{path}: byte {offset}: expected {expected}, found {found}")]
    Pickle {
        /// The file.
        path: PathBuf,
        /// Where in the file.
        offset: usize,
        /// What the format requires.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A quaternion whose numbers seem to stand in another order.
    #[error(
        "{path}: expected quaternions in the order x, y, z, w, found a robot that stays on its feet only in the order w, x, y, z; \
             give the order (--quat wxyz, or --quat xyzw to read it as it is) or write '# quat: wxyz' into the first line of a CSV file"
    )]
    QuatOrder {
        /// The file.
        path: PathBuf,
    },
    /// A file of another kind that is known.
    #[error("{path}: expected a motion, found {found}; {remedy}")]
    Foreign {
        /// The file.
        path: PathBuf,
        /// What it is.
        found: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A clip that cannot be a motion of this robot.
    #[error("{path}: {what}; `paid motion check` says more")]
    Implausible {
        /// The file.
        path: PathBuf,
        /// What was expected and what was found.
        what: String,
    },
    /// Something that neither the file nor an option states.
    #[error("{path}: {what} is not stated in the file; {remedy}")]
    Unstated {
        /// The file.
        path: PathBuf,
        /// What is missing.
        what: &'static str,
        /// How to state it.
        remedy: &'static str,
    },
    /// An order of joints for a file that has its own.
    #[error(
        "{path}: --joint-order: expected a file that does not state its order (.csv, .pkl), found an NPZ archive, which \
             has its own"
    )]
    JointOrder {
        /// The file.
        path: PathBuf,
    },
    /// A file name of no known format.
    #[error(
        "{path}: expected a motion of the robot: a name that ends in .npz, .csv or (to read) .pkl; a human's (.bvh, .amc) goes \
             through `paid motion retarget`"
    )]
    Extension {
        /// The file.
        path: PathBuf,
    },
    /// A kick that cannot be made.
    #[error(transparent)]
    Generate(#[from] GenerateError),
    /// The robot's TOML and MJCF do not fit together.
    #[error(transparent)]
    Robot(#[from] SpecError),
    /// The control rate that clips are to be brought to makes no sense.
    #[error("control rate (--rate, or the preset's): expected 10 to 2000 Hz, found {0}")]
    Rate(f64),
}
