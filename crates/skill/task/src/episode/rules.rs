//! How episodes run: what training and evaluation do differently.

/// What happens when the reference motion is over.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AtMotionEnd {
    /// The episode ends, as a truncation.
    End,
    /// The reference holds its last pose at rest and the episode continues.
    HoldLastPose,
}

/// What happens when a termination term is beyond its limit. A state that is not finite ends the episode in any case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OnFailure {
    /// The episode ends.
    End,
    /// The episode continues.
    Continue,
}

/// What happens after an episode has ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterEnd {
    /// A new episode begins at once.
    Restart,
    /// The environment continues and keeps reporting its end.
    Continue,
}

/// Observation noise, pushes and randomization.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbances {
    /// As the preset says.
    AsPreset,
    /// None. Perception errors stay if the preset's `in_evaluation` says so.
    Off,
}

/// Longest episode.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeLimit {
    /// The preset's `episode_length_s`.
    AsPreset,
    /// A number of control steps.
    Steps(u32),
}

/// What happens some time after the kick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AfterKick {
    /// The preset's share of the environments times out (`sampling.stop_after_kick_s`).
    AsPreset,
    /// Nothing.
    Continue,
}

/// Whether failures and misses are counted for adaptive sampling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplingStatistics {
    /// They are.
    Counted,
    /// They are not.
    Ignored,
}

/// Whether samples carry the reward terms of their step ([`crate::EnvSample::rewards`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RewardTermsInSamples {
    /// They do.
    Kept,
    /// They do not; this is cheaper.
    Dropped,
}

/// How the episodes of a shard run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct EpisodeRules {
    /// At the end of the reference motion. Without a reference there is no such end.
    pub at_motion_end: AtMotionEnd,
    /// When a termination term is beyond its limit.
    pub on_failure: OnFailure,
    /// After the end.
    pub after_end: AfterEnd,
    /// After a kick.
    pub after_kick: AfterKick,
    /// Noise, pushes and randomization.
    pub disturbances: Disturbances,
    /// Longest episode.
    pub time_limit: TimeLimit,
    /// Counts for adaptive sampling.
    pub sampling: SamplingStatistics,
    /// Reward terms in samples.
    pub reward_terms: RewardTermsInSamples,
}

impl EpisodeRules {
    /// Episodes as they are trained on: they end with the motion or a failure, begin again at once, and are disturbed.
    pub const TRAINING: Self = Self {
        at_motion_end: AtMotionEnd::End,
        on_failure: OnFailure::End,
        after_end: AfterEnd::Restart,
        after_kick: AfterKick::AsPreset,
        disturbances: Disturbances::AsPreset,
        time_limit: TimeLimit::AsPreset,
        sampling: SamplingStatistics::Counted,
        reward_terms: RewardTermsInSamples::Dropped,
    };

    /// Undisturbed episodes that continue after the motion and after failures, which the evaluator handles.
    pub const fn evaluation() -> Self {
        Self {
            at_motion_end: AtMotionEnd::HoldLastPose,
            on_failure: OnFailure::Continue,
            after_end: AfterEnd::Continue,
            after_kick: AfterKick::Continue,
            disturbances: Disturbances::Off,
            time_limit: TimeLimit::AsPreset,
            sampling: SamplingStatistics::Ignored,
            reward_terms: RewardTermsInSamples::Dropped,
        }
    }

    /// Longest episode where the preset's is `preset_steps` [control steps].
    pub(crate) fn max_steps(&self, preset_steps: u32) -> u32 {
        match self.time_limit {
            TimeLimit::AsPreset => preset_steps,
            TimeLimit::Steps(steps) => steps,
        }
    }
}

impl Default for EpisodeRules {
    /// [`EpisodeRules::TRAINING`].
    fn default() -> Self {
        Self::TRAINING
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_in_steps_replaces_the_presets() {
        assert_eq!(EpisodeRules::TRAINING.max_steps(500), 500);
        let short = EpisodeRules { time_limit: TimeLimit::Steps(3), ..EpisodeRules::evaluation() };
        assert_eq!(short.max_steps(500), 3);
    }
}
