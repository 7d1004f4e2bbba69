//! How far a stage is, and what its logs average over.

use std::collections::VecDeque;

use paid_task::{EndCause, TaskMetrics};
use serde::{Deserialize, Serialize};

use crate::record::{Named, Record};

/// Episodes that the mean return and length cover at least (rsl_rl keeps the last 100).
const WINDOW_EPISODES: u64 = 100;

/// Counters of a stage; saved with each checkpoint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Progress {
    /// Iterations done.
    pub iteration: u64,
    /// Environment steps done.
    pub samples: u64,
    /// Training time, earlier starts included `[s]`.
    pub elapsed_s: f64,
    /// The share of the run (0 to 1) that was over when the last iteration began, by iterations or wall clock.
    #[serde(default)]
    pub share: f64,
    /// Phases that have begun.
    #[serde(default)]
    pub phase: usize,
    /// Ended episodes, their steps and returns, one entry an iteration, newest last.
    window: VecDeque<(u64, u64, f64)>,
}

impl Progress {
    /// Adds the episodes of an iteration and drops what is no longer needed.
    pub fn add_episodes(&mut self, metrics: &TaskMetrics) {
        if metrics.episodes > 0 {
            self.window.push_back((metrics.episodes, metrics.episode_steps, metrics.episode_return_sum));
        }
        let mut total: u64 = self.window.iter().map(|w| w.0).sum();
        while let Some(oldest) = self.window.front()
            && total - oldest.0 >= WINDOW_EPISODES
        {
            total -= oldest.0;
            self.window.pop_front();
        }
    }

    /// Mean return and mean length `[control steps]` of the last episodes; zeros before the first.
    pub fn episode_means(&self) -> (f64, f64) {
        let episodes: u64 = self.window.iter().map(|w| w.0).sum();
        if episodes == 0 {
            return (0.0, 0.0);
        }
        let steps: u64 = self.window.iter().map(|w| w.1).sum();
        let returns: f64 = self.window.iter().map(|w| w.2).sum();
        (returns / episodes as f64, steps as f64 / episodes as f64)
    }
}

/// Puts the task's figures into a record: reward terms as means per second of simulated time (`control_dt_s` is the control
/// period), ends as shares of the ended episodes, everything else as metrics.
pub fn describe(metrics: &TaskMetrics, control_dt_s: f64, record: &mut Record) {
    let (mut rewards, mut ends, mut others) = (Named::default(), Named::default(), Named::default());
    for (name, value) in metrics.summary() {
        match name.split_once('/') {
            Some(("reward", term)) => rewards.push(term, value / control_dt_s),
            Some(("end", cause)) => ends.push(cause, value),
            Some(("tracking", error)) => others.push(error, value),
            // The record's own fields hold these two over a longer window.
            Some(("episode", "length" | "return")) => {}
            Some(("episode", figure)) => others.push(figure, value),
            _ => others.push(name, value),
        }
    }
    record.episodes = metrics.episodes;
    record.nan_resets = metrics.ended(EndCause::NotFinite);
    record.rewards = rewards;
    record.terminations = ends;
    record.metrics = others;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn episodes(count: u64, steps: u64, returns: f64) -> TaskMetrics {
        TaskMetrics {
            episodes: count,
            episode_steps: steps,
            episode_return_sum: returns,
            ..TaskMetrics::default()
        }
    }

    #[test]
    fn means_cover_the_last_hundred_episodes_and_no_older_iteration() {
        let mut progress = Progress::default();
        assert_eq!(progress.episode_means(), (0.0, 0.0));
        progress.add_episodes(&episodes(90, 900, 0.0));
        progress.add_episodes(&episodes(60, 1200, 120.0));
        assert_eq!(progress.episode_means(), (120.0 / 150.0, 14.0));
        progress.add_episodes(&episodes(40, 800, 80.0));
        assert_eq!(progress.episode_means(), (2.0, 20.0));
    }

    #[test]
    fn figures_land_in_their_groups() {
        let mut metrics = episodes(4, 40, 1.0);
        metrics.steps = 10;
        metrics.reward_terms[0] = 0.4;
        metrics.ends[EndCause::NotFinite.index()] = 2;
        metrics.ends[1] = 1;
        metrics.ends[EndCause::MotionEnd.index()] = 1;
        let mut record = Record::default();
        describe(&metrics, 0.02, &mut record);
        let first = paid_task::reward_names()[0];
        assert_eq!(record.rewards.get(first), Some(0.4 / 10.0 / 0.02));
        assert_eq!(record.terminations.get("not_finite"), Some(0.5));
        assert_eq!(record.nan_resets, 2);
        assert!(record.metrics.get("error_anchor_pos").is_some());
        assert!(record.metrics.get("kick/contact").is_some());
        assert!(record.metrics.get("length").is_none());
    }
}
