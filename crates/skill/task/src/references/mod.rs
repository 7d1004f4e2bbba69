//! The reference of each lane: its frame, where it lies in the world, and how far the robot is from it.

pub(crate) mod anchoring;
pub(crate) mod frame;
pub(crate) mod tracking;
