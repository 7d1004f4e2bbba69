//! Ball and goal: where they are placed, what the robot sees of them, and what counts as a kick.

pub(crate) mod contact_kind;
pub(crate) mod eyes;
pub(crate) mod kick;
pub(crate) mod kick_preset;
pub(crate) mod placement;
pub(crate) mod rolling;
pub(crate) mod shown;
