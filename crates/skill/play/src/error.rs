//! What can go wrong when a policy is to be played.

use thiserror::Error;

/// Motions, robot and rules of play that do not fit each other.
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
