//! Training of networks: cached forward and backward passes over feature-major matrices `[features, N]`.
//!
//! The networks themselves are [`paid_policy::net`]'s.

pub mod linear;
pub mod lstm;
mod network;

pub use lstm::{LstmCache, Steps};
pub use network::{Loss, Sequence, TrainNetwork, TrainWorkspace};
