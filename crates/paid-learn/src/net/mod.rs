//! Networks: layers with forward, cached forward and backward passes over feature-major matrices `[features, N]`.
//!
//! A network's shape ([`Network`]) is separate from its parameters (one flat vector, described by a [`Layout`]), so that
//! gradients, optimizer moments and checkpoints are flat vectors of the same layout.

mod layout;
mod linear;
mod lstm;
mod network;

pub use layout::{Layout, TensorSpec};
pub use linear::Linear;
pub use lstm::{Lstm, LstmCache, Steps};
pub use network::{CHUNK, Loss, Network, Sequence, State, StepWorkspace, TrainWorkspace};
