//! Scores of the policy in training by an outside evaluator, for the log alone.

use std::path::Path;

use paid_task::layers::KeyError;
use serde::{Deserialize, Serialize};

use crate::Named;

/// When a policy in training is evaluated, and how thoroughly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JudgeConfig {
    /// Iterations between two scores; 0: none. Iterations and not minutes, so that a log repeats.
    pub every_iterations: u64,
    /// Shots at a static ball, a multiple of [`JudgeConfig::PLACES`].
    pub shots: usize,
}

impl Default for JudgeConfig {
    /// Off. One shot from each place takes about 6 s of two cores in MuJoCo.
    fn default() -> Self {
        Self { every_iterations: 0, shots: Self::PLACES }
    }
}

impl JudgeConfig {
    /// Ball places of the effective workspace.
    pub const PLACES: usize = 63;

    /// True if the policy is to be evaluated after `iteration`.
    pub fn is_due(&self, iteration: u64) -> bool {
        self.every_iterations > 0 && iteration.is_multiple_of(self.every_iterations)
    }

    pub(crate) fn check(&self) -> Result<(), KeyError> {
        if self.shots > 0 && self.shots.is_multiple_of(Self::PLACES) {
            return Ok(());
        }
        let message = format!("expected a multiple of {} ball places, found {}", Self::PLACES, self.shots);
        Err(KeyError { key: "run.judge.shots".to_owned(), message })
    }
}

/// An evaluator of policies in training. Training does not look at the scores: with and without it the weights are the same, bit for
/// bit, unless wall clock ends or anneals the run.
pub trait Judge {
    /// Figures of the policy in the checkpoint `policy` (weights, normalizers, preset), by name; none if there is nothing to
    /// report.
    fn score(&mut self, policy: &Path) -> Named;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_evaluation_is_due_every_n_iterations_or_never() {
        let judge = JudgeConfig { every_iterations: 20, ..JudgeConfig::default() };
        assert_eq!([19, 20, 40].map(|i| judge.is_due(i)), [false, true, true]);
        assert!(!JudgeConfig::default().is_due(20));
    }

    #[test]
    fn shots_are_the_same_from_every_place() {
        for (shots, fits) in [(0, false), (62, false), (63, true), (126, true)] {
            let judge = JudgeConfig { shots, ..JudgeConfig::default() };
            assert_eq!(judge.check().is_ok(), fits, "{shots}");
        }
    }
}
