//! A comparison from one plan: methods are trained with the same budget and judged alike, beside the paper's figures.

pub mod curves;
mod plan;
mod report;
mod score;
mod seeds;

pub use plan::{Contender, Entry, JudgePlan, Plan, StagePlan};
pub use report::{Comparison, Row};
pub use score::{ClipShots, EYES, Judgment, PanelScore, Scores, Shots};
