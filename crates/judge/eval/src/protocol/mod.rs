//! The two protocols of the paper, and matches.

pub mod matches;
pub mod shooting;
pub mod tracking;
