//! What measures this project, not a policy: the program uses it, no other crate.
//!
//! - [`compare`]: methods trained with equal budgets and scored the same way, from one plan.
//! - [`agreement`], [`tracking_agreement`]: one policy in both engines, and where they part ([`divergence`]).
//! - [`dataset`]: what a set of kicks covers.
//! - [`mod@bench`]: physics steps a second.
//!
//! Begin reading with `compare/plan.rs`.

pub mod agreement;
pub mod bench;
pub mod compare;
pub mod dataset;
pub mod divergence;
pub mod results;
pub mod tracking_agreement;
