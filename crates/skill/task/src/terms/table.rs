//! The table of terms that `paid task terms` prints.

use serde::Serialize;

use paid_policy::observation::{ObservationId, ObservationInfo};

use crate::terms::parameters::{ParameterInfo, Parameters, Requirement};
use crate::{RewardPreset, TerminationPreset};

/// A term as a row of the table.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct TermInfo {
    /// `observation`, `reward` or `termination`.
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
    pub needs: Vec<String>,
    /// Parameters; a reward term also has a weight. An observation term has the half-width of its noise.
    pub parameters: Vec<ParameterInfo>,
}

impl TermInfo {
    pub(crate) fn new<T: Parameters>(
        kind: &'static str,
        name: &'static str,
        [unit, frame]: [&'static str; 2],
        needs: &'static [Requirement],
    ) -> Self {
        let needs = needs.iter().map(ToString::to_string).collect();
        Self { kind, name, summary: T::SUMMARY.trim(), unit, frame, needs, parameters: T::parameters() }
    }

    fn of_observation(info: &ObservationInfo) -> Self {
        let noise = ParameterInfo {
            name: "noise",
            summary:
                "Half-width of uniform noise on each number of the policy's copy, as the paper's presets have it; 0 where `observations.noise` leaves it out."
                    .into(),
            default: format!("{:?}", info.noise.half_width),
            unit: info.unit,
            reason: if info.noise.reason.is_empty() { "none" } else { info.noise.reason },
        };
        Self {
            kind: "observation",
            name: info.name,
            summary: info.summary,
            unit: info.unit,
            frame: info.frame,
            needs: info.needs.iter().map(ToString::to_string).collect(),
            parameters: vec![noise],
        }
    }
}

/// Every observation, reward and termination term.
pub fn terms_table() -> Vec<TermInfo> {
    let mut table: Vec<TermInfo> =
        ObservationId::all().map(|id| TermInfo::of_observation(&id.info())).collect();
    table.extend(RewardPreset::table());
    table.extend(TerminationPreset::table());
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::rewards::REWARD_NAMES;
    use crate::terms::terminations::TERMINATION_NAMES;

    #[test]
    fn every_term_has_a_row_with_its_summary_and_parameters() {
        let table = terms_table();
        let names = |kind| table.iter().filter(|t| t.kind == kind).map(|t| t.name).collect::<Vec<_>>();
        assert_eq!(names("observation"), ObservationId::BUILTIN.map(|id| id.name()));
        assert_eq!(names("reward"), REWARD_NAMES);
        assert_eq!(names("termination"), TERMINATION_NAMES);
        assert!(table.iter().all(|t| t.summary.ends_with('.') && !t.frame.is_empty()), "{table:?}");
        let prox = table.iter().find(|t| t.name == "ball_prox").expect("a term");
        assert_eq!(prox.needs, ["a ball"]);
        let keys: Vec<_> = prox.parameters.iter().map(|p| (p.name, p.default.as_str(), p.unit)).collect();
        assert_eq!(keys, [("sigma", "4.0", "m"), ("from", "\"anchor\"", ""), ("frozen", "true", "")]);
    }
}
