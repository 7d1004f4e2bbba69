//! What measures this project, not a policy: the program uses it, no other crate.
//!
//! - [`compare`]: methods trained with one budget and judged alike, from one plan.
//! - [`agreement`], [`tracking_agreement`], [`gap`]: one policy in both engines, where they part ([`divergence`]) and why.
//! - [`dataset`]: what a set of kicks covers.
//! - [`mod@bench`]: physics steps a second.
//!
//! Begin reading with `compare/plan.rs`.

pub mod agreement;
pub mod bench;
pub mod compare;
pub mod dataset;
pub mod divergence;
pub mod gap;
pub mod like_mujoco;
pub mod results;
pub mod tracking_agreement;
