//! Reward terms: one small pure function each, over lanes, without weight.

pub(crate) mod regularization;
pub(crate) mod soccer;
pub(crate) mod tracking;
