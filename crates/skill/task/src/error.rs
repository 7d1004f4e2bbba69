//! What can go wrong when a task is built.

use paid_play::PlayError;
use paid_policy::observation::ObservationError;
use thiserror::Error;

/// A task that cannot be built or driven as asked.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum TaskError {
    /// Motions, robot and rules of play do not fit each other.
    #[error(transparent)]
    Play(PlayError),
    /// The preset's text is not a valid preset.
    #[error("preset '{name}': {message}")]
    Preset {
        /// File or built-in name.
        name: String,
        /// Place, expected, found.
        message: String,
    },
    /// A preset value is outside its range.
    #[error("preset: {key} is {found}, expected {expected}")]
    Value {
        /// Dotted key.
        key: String,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// A preset's list of observation terms cannot be observed.
    #[error("preset: observations.{list}: {error}")]
    Observations {
        /// `policy` or `critic`.
        list: &'static str,
        /// What is wrong with it.
        error: ObservationError,
    },
    /// A term needs a reference motion and the preset has none.
    #[error("preset: {kind} term '{name}' needs a reference motion, but reference is \"none\"")]
    NeedsReference {
        /// `observation`, `reward` or `termination`.
        kind: &'static str,
        /// Name of the term.
        name: &'static str,
    },
    /// The robot description lacks a name that the task needs.
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
    /// The number of environments does not fill whole lane groups.
    #[error("{num_envs} environments do not fill groups of {lanes} lanes")]
    Lanes {
        /// Environments asked for.
        num_envs: usize,
        /// Lanes of a group.
        lanes: usize,
    },
    /// The simulator could not be built.
    #[error("simulator: {0}")]
    Simulator(String),
    /// An evaluation request names something that does not exist.
    #[error("evaluation: {0}")]
    Eval(String),
}

impl From<PlayError> for TaskError {
    fn from(error: PlayError) -> Self {
        match error {
            PlayError::Value { key, expected, found } => Self::Value { key, expected, found },
            error => Self::Play(error),
        }
    }
}

impl TaskError {
    /// A value of a part's preset, which stands at `key`.
    pub(crate) fn below(key: &str, error: paid_track::ValueError) -> Self {
        Self::Value { key: format!("{key}.{}", error.key), expected: error.expected, found: error.found }
    }
}
