//! What can go wrong when a policy is to be played.

use std::path::PathBuf;

use thiserror::Error;

/// A policy, its motions, its robot and the rules by which it is played do not fit each other, or cannot be read.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PlayError {
    /// A value of the preset is outside its range.
    #[error("preset: {key} is {found}, expected {expected}")]
    Value {
        /// Dotted key.
        key: String,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// The preset lacks what a player needs, or an override is not about how a policy is played.
    #[error("preset: {0}")]
    Preset(String),
    /// A file could not be read.
    #[error("cannot read {}: {reason}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The operating system's reason.
        reason: String,
    },
    /// A checkpoint is damaged or none; the text names it.
    #[error("{0}")]
    Unreadable(String),
    /// A policy's file does not hold what it takes to play it.
    #[error("{}: {message}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// Entry, expected, found.
        message: String,
    },
    /// A robot's file; the text names it and the line.
    #[error("{0}")]
    RobotFile(String),
    /// The robot description lacks a name that playing needs.
    #[error("robot: {role} '{name}' is not in the model")]
    Name {
        /// What the name is for.
        role: &'static str,
        /// The name.
        name: String,
    },
    /// The robot's specification does not fit its model.
    #[error("robot: {0}")]
    Robot(String),
    /// The reference library does not fit the robot or is empty.
    #[error("reference library: {0}")]
    Library(String),
}

impl PlayError {
    pub(crate) fn value(key: &str, expected: &str, found: impl ToString) -> Self {
        Self::Value { key: key.to_owned(), expected: expected.to_owned(), found: found.to_string() }
    }
}
