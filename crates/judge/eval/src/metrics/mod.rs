//! Measures as pure functions over trajectories and counts.

pub mod shooting;
pub mod statistics;
pub mod tracking;
