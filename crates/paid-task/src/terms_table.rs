//! The table of terms that `paid task terms` prints.

use serde::Serialize;

use crate::parameters::{Need, ParameterInfo, Parameters};
use crate::{RewardPreset, TerminationPreset};

/// A term as a row of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TermInfo {
    /// `reward` or `termination`.
    pub kind: &'static str,
    /// Key in the preset.
    pub name: &'static str,
    /// What it measures.
    pub summary: &'static str,
    /// SI unit of what it measures; empty for pure numbers.
    pub unit: &'static str,
    /// Frame in which it measures.
    pub frame: &'static str,
    /// What it needs of the task.
    pub needs: &'static [Need],
    /// Parameters; a reward term has a weight besides.
    pub parameters: Vec<ParameterInfo>,
}

impl TermInfo {
    pub(crate) fn new<T: Parameters>(
        kind: &'static str,
        name: &'static str,
        [unit, frame]: [&'static str; 2],
        needs: &'static [Need],
    ) -> Self {
        Self { kind, name, summary: T::SUMMARY.trim(), unit, frame, needs, parameters: T::parameters() }
    }
}

/// Every reward and termination term, in the order in which they are evaluated.
pub fn terms_table() -> Vec<TermInfo> {
    let mut table = RewardPreset::table();
    table.extend(TerminationPreset::table());
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{REWARD_NAMES, TERMINATION_NAMES};

    #[test]
    fn every_term_has_a_row_with_its_summary_and_parameters() {
        let table = terms_table();
        let names = |kind| table.iter().filter(|t| t.kind == kind).map(|t| t.name).collect::<Vec<_>>();
        assert_eq!(names("reward"), REWARD_NAMES);
        assert_eq!(names("termination"), TERMINATION_NAMES);
        assert!(table.iter().all(|t| t.summary.ends_with('.') && !t.frame.is_empty()), "{table:?}");
        let prox = table.iter().find(|t| t.name == "ball_prox").expect("a term");
        assert_eq!(prox.needs, [Need::Ball]);
        let keys: Vec<_> = prox.parameters.iter().map(|p| (p.name, p.default.as_str(), p.unit)).collect();
        assert_eq!(keys, [("sigma", "4.0", "m"), ("from", "\"anchor\"", "")]);
    }
}
