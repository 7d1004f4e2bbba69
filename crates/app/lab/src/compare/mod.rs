//! A comparison from one plan: methods are trained with equal budgets and scored the same way, next to the paper's figures.

mod check;
mod contender;
#[cfg(test)]
mod contender_tests;
mod count;
pub mod curves;
pub mod films;
mod origin;
mod plan;
mod print;
mod report;
mod same_run;
mod score;
mod seeds;
mod tracks;

pub use contender::Contender;
pub use count::Count;
pub use origin::Origin;
pub use plan::{Entry, JudgePlan, Plan, StagePlan};
pub use report::{Comparison, Row};
pub use same_run::{difference, has_run};
pub use score::{ClipShots, EYES, Judgment, PanelScore, Scores, Shots};
pub use tracks::ClipTrack;
