//! The two protocols of the paper.

pub mod shooting;
pub mod tracking;
