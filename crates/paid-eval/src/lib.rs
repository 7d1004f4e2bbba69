//! Scores a policy: how well it follows the motions, how well it shoots, and pictures of what it does.
//!
//! [`metrics`] are pure functions; [`episodes`] runs trials in batches on the task's own environments; [`tracking`] and
//! [`shooting`] are the two protocols; [`picture`] draws.

pub mod episodes;
mod error;
pub mod file;
pub mod metrics;
pub mod picture;
pub mod policy;
mod protocol;
pub mod table;

pub use error::EvalError;
pub use protocol::{shooting, tracking};
