//! How episodes begin, continue and end: starts and resets, which motion and phase, what is drawn for each, and an evaluation's rules.

pub(crate) mod control;
pub(crate) mod curriculum;
pub(crate) mod disturb;
pub(crate) mod draw_params;
pub(crate) mod eyes;
pub(crate) mod reset;
pub(crate) mod rules;
pub(crate) mod sampler;
pub(crate) mod stance;
pub(crate) mod starts;
pub(crate) mod variant;
