//! Training of networks: cached forward and backward passes over feature-major matrices `[features, N]`.
//!
//! The networks themselves are [`paid_policy::net`]'s.

mod gates;
pub mod linear;
pub mod lstm;
mod network;

pub use gates::{GateStats, gate_stats};
pub use lstm::{LstmCache, Steps};
pub use network::{Loss, Sequence, TrainNetwork, TrainWorkspace};
