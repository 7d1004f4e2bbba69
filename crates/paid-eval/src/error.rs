//! What can go wrong in an evaluation.

use std::path::PathBuf;

use paid_task::TaskError;
use thiserror::Error;

/// An evaluation that cannot be run or written down.
#[derive(Debug, Error)]
pub enum EvalError {
    /// The task refuses.
    #[error(transparent)]
    Task(#[from] TaskError),
    /// The referee is missing or refuses the scene.
    #[error(transparent)]
    Mujoco(#[from] paid_mujoco::MujocoError),
    /// The policy does not fit the task.
    #[error("policy: {what}: the task has {task}, the policy {policy}")]
    Contract {
        /// What differs.
        what: &'static str,
        /// The task's value.
        task: usize,
        /// The policy's value.
        policy: usize,
    },
    /// The policy cannot be read or run.
    #[error("policy: {0}")]
    Policy(String),
    /// The policy returned a number that is not finite.
    #[error(
        "policy: action {action} of trial {trial} at control step {step} is {value}, expected a finite number"
    )]
    Action {
        /// Index in the action vector.
        action: usize,
        /// Trial.
        trial: usize,
        /// Control step.
        step: usize,
        /// The value.
        value: f32,
    },
    /// An option makes no sense.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// Name of the option.
        option: &'static str,
        /// What is allowed.
        expected: String,
        /// What was given.
        found: String,
    },
    /// A file cannot be written.
    #[error("{path}: {source}")]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's answer.
        source: std::io::Error,
    },
}
