//! Why nothing is drawn.

use paid_files::FileError;
use thiserror::Error;

/// A drawing that cannot be written.
#[derive(Debug, Error)]
pub enum PlotError {
    /// A file.
    #[error(transparent)]
    File(#[from] FileError),
    /// An animation's file name or size.
    #[error("record: expected {expected}, found {found}")]
    Animation {
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
}
