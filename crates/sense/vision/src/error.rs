//! What can be wrong with an image, a detector or their settings.

use std::path::PathBuf;

use paid_onnx::OnnxError;
use thiserror::Error;

/// Why a step from image to ball failed.
#[derive(Debug, Error)]
pub enum VisionError {
    /// A value that makes no sense.
    #[error("{what}: expected {expected}, found {found}")]
    Value {
        /// Which one.
        what: String,
        /// What is accepted.
        expected: String,
        /// What was given.
        found: String,
    },
    /// A detector file that cannot be read or run.
    #[error(transparent)]
    Onnx(#[from] OnnxError),
    /// A detector whose input or outputs are none that this program knows.
    #[error("{path}: not a detector that this program reads: expected {expected}; found {found}")]
    Detector {
        /// The file.
        path: PathBuf,
        /// Names and shapes of the known kinds.
        expected: String,
        /// Names and shapes in the file.
        found: String,
    },
    /// A file that cannot be written.
    #[error("{path}: {source}")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

impl VisionError {
    /// A value that makes no sense.
    pub(crate) fn value(
        what: impl Into<String>,
        expected: impl Into<String>,
        found: impl Into<String>,
    ) -> Self {
        Self::Value { what: what.into(), expected: expected.into(), found: found.into() }
    }
}
