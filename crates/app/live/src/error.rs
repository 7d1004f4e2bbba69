//! What can go wrong with the page.

use std::net::SocketAddr;

use paid_eval::EvalError;
use paid_task::TaskError;
use thiserror::Error;

/// A page that cannot be served, or a scene that cannot continue.
#[derive(Debug, Error)]
pub enum LiveError {
    /// The address is taken or not allowed.
    #[error("{address}: expected a free address of this machine, found: {reason}")]
    Bind {
        /// The address that was asked for.
        address: SocketAddr,
        /// What the system says.
        reason: std::io::Error,
    },
    /// The server cannot be started.
    #[error("page: the server does not start: {0}")]
    Server(std::io::Error),
    /// The system has no random numbers for a token.
    #[error("page: no random number for the token: {0}")]
    Token(getrandom::Error),
    /// The scene cannot be written as JSON.
    #[error("page: the scene cannot be written: {0}")]
    Json(#[from] serde_json::Error),
    /// A policy that gives a number that is none.
    #[error("policy: expected finite actions, found {value} for joint {joint}")]
    Action {
        /// Number of the action.
        joint: usize,
        /// Its value.
        value: f32,
    },
    /// Policy, task or engine.
    #[error(transparent)]
    Eval(#[from] EvalError),
    /// The task refuses.
    #[error(transparent)]
    Task(#[from] TaskError),
}
