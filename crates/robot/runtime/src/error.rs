//! Why a robot does not start.

use std::path::PathBuf;

use thiserror::Error;

use crate::LinkError;

/// Something does not fit, or is missing.
#[derive(Debug, Error)]
pub enum DeployError {
    /// A file of limits or of onboard perception.
    #[error("{file}: {message}")]
    Limits {
        /// The file.
        file: PathBuf,
        /// Key, expected, found.
        message: String,
    },
    /// The policy, its motions or its robot.
    #[error("{0}")]
    Policy(String),
    /// The eyes: camera, LiDAR, detector.
    #[error("eyes: {0}")]
    Eyes(String),
    /// The link.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// A log.
    #[error("{file}: {message}")]
    Log {
        /// The file.
        file: PathBuf,
        /// What is wrong with it.
        message: String,
    },
    /// The operator stopped it before the start.
    #[error("stopped before the start: the vendor's controller was not yet reported released")]
    Stopped,
    /// Refused by the robot or the network.
    #[error("refused to start: {0}")]
    Refused(String),
}

impl DeployError {
    pub(crate) fn policy(error: impl ToString) -> Self {
        Self::Policy(error.to_string())
    }
    #[cfg(feature = "perception")]
    pub(crate) fn eyes(error: impl ToString) -> Self {
        Self::Eyes(error.to_string())
    }
}
