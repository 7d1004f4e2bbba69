//! Why a virtual robot does not start or ends.

use paid_runtime::{DeployError, LinkError};
use thiserror::Error;

/// Something of the simulation, the runtime or the link between them.
#[derive(Debug, Error)]
pub enum TwinError {
    /// The simulation.
    #[error("{0}")]
    Simulation(String),
    /// The runtime or its eyes.
    #[error(transparent)]
    Runtime(#[from] DeployError),
    /// The link.
    #[error(transparent)]
    Link(#[from] LinkError),
}

impl TwinError {
    pub(crate) fn simulation(error: impl ToString) -> Self {
        Self::Simulation(error.to_string())
    }
    pub(crate) fn eyes(error: impl ToString) -> Self {
        Self::Runtime(DeployError::Eyes(error.to_string()))
    }
    pub(crate) fn refused(why: String) -> Self {
        Self::Runtime(DeployError::Refused(why))
    }
}
