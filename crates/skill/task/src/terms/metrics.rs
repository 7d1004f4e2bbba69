//! Sums and counts of what happened in a shard since they were last taken.

use serde::{Deserialize, Serialize};

use crate::{EndCause, TRACKING_NAMES, end_names, reward_names};

/// What happened with the ball in the episodes that ended.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct KickStatistics {
    /// Episodes that ended while the scene had a ball.
    pub episodes: u64,
    /// Of these, with a contact.
    pub contacts: u64,
    /// Of these, with the labeled foot first.
    pub correct_foot: u64,
    /// Sum over contacts of the ball's horizontal speed, the largest of the outcome window `[m/s]`.
    pub ball_speed_sum: f64,
    /// Sum over contacts of the cosine between the ball's horizontal velocity (at that largest speed) and the goal's
    /// direction.
    pub ball_cosine_sum: f64,
    /// Episodes in which the ball crossed the goal plane inside the goal before they ended.
    pub goals: u64,
    /// Episodes whose ball, at its largest outcome speed, was heading into the goal mouth along a straight line.
    pub on_target: u64,
}

/// Sums and counts over a number of environment steps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TaskMetrics {
    /// Environment steps.
    pub steps: u64,
    /// Sum over steps of each term times weight times control period, order of [`reward_names`].
    pub reward_terms: Vec<f64>,
    /// Sums over steps of the tracking errors, order of [`TRACKING_NAMES`].
    #[serde(with = "crate::codec::array")]
    pub tracking: [f64; TRACKING_NAMES.len()],
    /// Largest speed of the labeled kicking foot's center of mass, summed over episodes that ended `[m/s]`.
    pub kick_foot_peak_sum: f64,
    /// The same of the reference over the same frames.
    pub reference_foot_peak_sum: f64,
    /// Episodes that ended.
    pub episodes: u64,
    /// Their steps.
    pub episode_steps: u64,
    /// Their returns (undiscounted).
    pub episode_return_sum: f64,
    /// How they ended, order of [`end_names`].
    pub ends: Vec<u64>,
    /// The ball.
    pub kick: KickStatistics,
}

impl Default for TaskMetrics {
    fn default() -> Self {
        Self {
            steps: 0,
            reward_terms: vec![0.0; reward_names().len()],
            tracking: [0.0; TRACKING_NAMES.len()],
            kick_foot_peak_sum: 0.0,
            reference_foot_peak_sum: 0.0,
            episodes: 0,
            episode_steps: 0,
            episode_return_sum: 0.0,
            ends: vec![0; end_names().len()],
            kick: KickStatistics::default(),
        }
    }
}

fn ratio(sum: f64, count: u64) -> f64 {
    if count == 0 { 0.0 } else { sum / count as f64 }
}

impl KickStatistics {
    /// Share of the episodes whose ball was on target; 0 without episodes.
    pub fn on_target_share(&self) -> f64 {
        ratio(self.on_target as f64, self.episodes)
    }
}

impl TaskMetrics {
    /// Adds another shard's or another iteration's sums. Merge in a fixed order for repeatable rounding.
    pub fn merge(&mut self, other: &Self) {
        self.steps += other.steps;
        for (a, b) in self.reward_terms.iter_mut().zip(&other.reward_terms) {
            *a += b;
        }
        for (a, b) in self.tracking.iter_mut().zip(other.tracking) {
            *a += b;
        }
        self.kick_foot_peak_sum += other.kick_foot_peak_sum;
        self.reference_foot_peak_sum += other.reference_foot_peak_sum;
        self.episodes += other.episodes;
        self.episode_steps += other.episode_steps;
        self.episode_return_sum += other.episode_return_sum;
        for (a, b) in self.ends.iter_mut().zip(&other.ends) {
            *a += b;
        }
        self.kick.episodes += other.kick.episodes;
        self.kick.contacts += other.kick.contacts;
        self.kick.correct_foot += other.kick.correct_foot;
        self.kick.ball_speed_sum += other.kick.ball_speed_sum;
        self.kick.ball_cosine_sum += other.kick.ball_cosine_sum;
        self.kick.goals += other.kick.goals;
        self.kick.on_target += other.kick.on_target;
    }

    /// Episodes that ended for a cause.
    pub fn ended(&self, cause: EndCause) -> u64 {
        self.ends[cause.index()]
    }

    /// Every figure by name, ready for a log: `reward/<term>` and `tracking/<error>` are means per step, `episode/*` means per
    /// ended episode, `end/<cause>` shares of the ended episodes, `kick/*` shares of episodes or means per contact. A
    /// mean over nothing is 0.
    pub fn summary(&self) -> Vec<(String, f64)> {
        let mut out = Vec::new();
        for (name, sum) in reward_names().iter().zip(&self.reward_terms) {
            out.push((format!("reward/{name}"), ratio(*sum, self.steps)));
        }
        out.push(("reward/total".into(), ratio(self.reward_terms.iter().sum(), self.steps)));
        for (name, sum) in TRACKING_NAMES.iter().zip(self.tracking) {
            out.push((format!("tracking/{name}"), ratio(sum, self.steps)));
        }
        out.push(("episode/length".into(), ratio(self.episode_steps as f64, self.episodes)));
        out.push(("episode/return".into(), ratio(self.episode_return_sum, self.episodes)));
        let peak = ratio(self.kick_foot_peak_sum, self.episodes);
        out.push(("episode/kick_foot_peak".into(), peak));
        out.push((
            "episode/kick_foot_peak_reference".into(),
            ratio(self.reference_foot_peak_sum, self.episodes),
        ));
        for (name, count) in end_names().iter().zip(&self.ends) {
            out.push((format!("end/{name}"), ratio(*count as f64, self.episodes)));
        }
        let kick = &self.kick;
        out.push(("kick/contact".into(), ratio(kick.contacts as f64, kick.episodes)));
        out.push(("kick/correct_foot".into(), ratio(kick.correct_foot as f64, kick.contacts)));
        out.push(("kick/ball_speed".into(), ratio(kick.ball_speed_sum, kick.contacts)));
        out.push(("kick/ball_cosine".into(), ratio(kick.ball_cosine_sum, kick.contacts)));
        out.push(("kick/goal".into(), ratio(kick.goals as f64, kick.episodes)));
        out.push(("kick/on_target".into(), kick.on_target_share()));
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn merged_metrics_average_over_all_steps() {
        let mut a = TaskMetrics { steps: 10, ..TaskMetrics::default() };
        a.reward_terms[0] = 5.0;
        let mut b = TaskMetrics { steps: 30, episodes: 2, episode_steps: 100, ..TaskMetrics::default() };
        b.reward_terms[0] = 3.0;
        b.ends[EndCause::MotionEnd.index()] = 1;
        a.merge(&b);
        let summary = a.summary();
        let get = |name: &str| summary.iter().find(|(n, _)| n == name).expect("present").1;
        assert_eq!(get("reward/anchor_pos"), 0.2);
        assert_eq!(get("episode/length"), 50.0);
        assert_eq!(get("end/motion_end"), 0.5);
        assert_eq!(get("kick/contact"), 0.0);
    }
}
