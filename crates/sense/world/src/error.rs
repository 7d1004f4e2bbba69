//! Errors of onboard perception and its recordings.

use std::path::PathBuf;

use thiserror::Error;

/// Why perception cannot run, or a recording cannot be used.
#[derive(Debug, Error)]
pub enum SightError {
    /// A detector, a camera or an image.
    #[error(transparent)]
    Vision(#[from] paid_vision::VisionError),
    /// The LiDAR's odometry.
    #[error(transparent)]
    Lidar(#[from] paid_lidar::LidarError),
    /// A constant of tracker or memory.
    #[error(transparent)]
    Value(#[from] paid_track::ValueError),
    /// A robot without a part that perception refers to.
    #[error("robot {robot}: expected a body '{body}', found none")]
    Body {
        /// The robot.
        robot: String,
        /// The body.
        body: String,
    },
    /// A message that does not fit the robot.
    #[error("{what}: expected {expected}, found {found}")]
    Message {
        /// Which message.
        what: &'static str,
        /// What is accepted.
        expected: String,
        /// What came.
        found: String,
    },
    /// A file that cannot be read or written.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A recording that is not what it should be.
    #[error("{path}: {place}: expected {expected}, found {found}")]
    Recording {
        /// The file.
        path: PathBuf,
        /// Topic and number of the message, or the file as a whole.
        place: String,
        /// What is accepted.
        expected: String,
        /// What was found.
        found: String,
    },
    /// Something in a recording that perception cannot take or be set up from.
    #[error("{path}: {place}: {source}")]
    Place {
        /// The file.
        path: PathBuf,
        /// Topic and number of the message.
        place: String,
        /// What is wrong there.
        source: Box<SightError>,
    },
    /// Too little to fit constants to.
    #[error("sightings: expected {expected}, found {found}")]
    Fit {
        /// What is needed.
        expected: &'static str,
        /// What there is.
        found: String,
    },
}
