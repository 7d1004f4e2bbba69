//! What reward and termination terms have in common: what they read, and how another crate adds its own.

mod input;
pub(crate) mod metrics;
mod own;
pub mod parameters;
pub(crate) mod rewards;
mod set;
pub(crate) mod table;
pub(crate) mod terminations;

pub use input::TermInput;
pub use own::{OwnRewards, OwnTerminations};
pub(crate) use own::{own_reward_names, own_reward_table, own_termination_names, own_termination_table};
pub use set::TermSet;
