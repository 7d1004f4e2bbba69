//! What can go wrong around a training run.

use std::path::{Path, PathBuf};

use paid_task::layers::LayerError;
use thiserror::Error;

/// A failure of the trainer; its text is one sentence that names the file and place.
#[derive(Debug, Error)]
pub enum TrainError {
    /// A file could not be written (full disk, no permission, a file where a folder is needed).
    #[error("cannot write {path}: {source}")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A file could not be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file or folder.
        path: PathBuf,
        /// The operating system's reason.
        source: std::io::Error,
    },
    /// A preset file or override does not fit.
    #[error("preset {place}: {message}")]
    Preset {
        /// File and line, built-in preset, or `--set KEY=VALUE`.
        place: String,
        /// Key, expected, found.
        message: String,
    },
    /// A run folder is not in the state that the command needs.
    #[error("run folder {path}: {message}")]
    Folder {
        /// The folder.
        path: PathBuf,
        /// Expected and found.
        message: String,
    },
    /// A file that the learner's crate wrote or read for us.
    #[error(transparent)]
    File(#[from] paid_learn::CheckpointError),
    /// A checkpoint does not fit the run.
    #[error("checkpoint {path}: {message}")]
    Checkpoint {
        /// The file.
        path: PathBuf,
        /// Entry, expected, found.
        message: String,
    },
    /// A policy's file or its robot.
    #[error(transparent)]
    Play(#[from] paid_play::PlayError),
    /// Motions, robot or task could not be built.
    #[error("{0}")]
    Setup(String),
    /// One of several ranks does not fit the others; each of them has this error.
    #[error("{0}")]
    Ranks(String),
}

impl From<LayerError> for TrainError {
    fn from(LayerError { place, message }: LayerError) -> Self {
        Self::Preset { place, message }
    }
}

impl TrainError {
    /// Adapter for `map_err` on writing `path`.
    pub(crate) fn write(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Write { path: path.to_owned(), source }
    }
    /// Adapter for `map_err` on reading `path`.
    pub(crate) fn read(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Read { path: path.to_owned(), source }
    }
}
