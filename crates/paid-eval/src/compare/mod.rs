//! A comparison from one plan: methods are trained with the same budget and judged alike, beside the paper's figures.

mod plan;
mod report;
mod score;

pub use plan::{Contender, Entry, JudgePlan, Plan, StagePlan};
pub use report::{Comparison, Row};
pub use score::{EYES, Judgment, PanelScore, Scores, Shots};
