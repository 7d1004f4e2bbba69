//! What can go wrong in an identification.

use std::path::PathBuf;

use paid_physics::PhysicsError;
use thiserror::Error;

/// An identification or simulated experiment that cannot be done.
#[derive(Debug, Error)]
pub enum SysidError {
    /// A file cannot be read.
    #[error("{path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
    /// A measurement file is not as it should be.
    #[error("{path}, line {line}, column '{column}': expected {expected}, found {found}")]
    Csv {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
    },
    /// A measurement file whose runs no ball can have made.
    #[error("{path}, {place}: expected {expected}, found {found}: {hint}")]
    Implausible {
        /// The file.
        path: PathBuf,
        /// Which run.
        place: String,
        /// What should be there.
        expected: String,
        /// What is there.
        found: String,
        /// The likely cause, and what to do.
        hint: String,
    },
    /// The best ball does not move as the filmed one.
    #[error(
        "identification: expected a ball that meets the {what} to {limit_mm:.1} mm (root mean square), found {error_mm:.1} mm at best; nothing \
         was written: {hint}"
    )]
    Misfit {
        /// Drops or rolls.
        what: &'static str,
        /// Root mean square of measured less simulated positions `[mm]`.
        error_mm: f64,
        /// Most that is accepted `[mm]`.
        limit_mm: f64,
        /// What to look for.
        hint: String,
    },
    /// A surface file is not as it should be.
    #[error("{path}: {message}")]
    Surface {
        /// The file.
        path: PathBuf,
        /// Place, expected, found.
        message: String,
    },
    /// An option makes no sense.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// Its name.
        option: String,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// The engine refuses the scene.
    #[error(transparent)]
    Physics(#[from] PhysicsError),
    /// MuJoCo is missing or refuses the scene.
    #[error("{0}")]
    Mujoco(String),
    /// No candidate gave a finite loss.
    #[error(
        "identification: expected at least one candidate with a finite loss, found none in {0} generations"
    )]
    NoFit(usize),
}

impl SysidError {
    /// An option outside its range.
    pub(crate) fn option(option: &str, expected: &str, found: impl ToString) -> Self {
        Self::Option { option: option.to_owned(), expected: expected.to_owned(), found: found.to_string() }
    }
}
