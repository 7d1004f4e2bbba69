//! Networks: layers and their forward passes over feature-major matrices `[features, N]`.
//!
//! A network's shape ([`Network`]) is separate from its parameters (one flat vector, described by a [`Layout`]), so that
//! gradients, optimizer moments and checkpoints are flat vectors of the same layout.

mod layout;
mod linear;
mod lstm;
mod network;
mod weights;

pub use layout::{Layout, TensorSpec};
pub use linear::Linear;
pub use lstm::{Cell, Lstm};
pub use network::{CHUNK, Network, State, StepWorkspace};
pub use weights::{PackedWeights, Weights};
