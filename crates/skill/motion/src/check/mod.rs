//! Is a clip fit for a robot to follow? Measures, limits and a verdict with plain reasons.
//!
//! Every aspect is measured ([`Measures`]), compared with two limits ([`CheckLimits`]) and, where a limit is passed, reported as a
//! [`Finding`]. A clip's verdict is that of its worst finding.

mod contact;
mod limits;
mod measure;
mod shapes;
#[cfg(test)]
mod tests;
mod verdict;

pub use contact::{FootContact, foot_contacts};
pub use limits::{CheckLimits, Limit};
pub use measure::{Measures, Worst, measure};
pub(crate) use shapes::nearest_points;
pub use shapes::{collision_pairs, lower_leg, rod};
pub use verdict::{Aspect, ClipReport, Finding, Verdict, check_clip, doubts, ends_away, mixed_rates};
