//! One episode of a policy, to look at.

use paid_task::{EpisodeRules, InitialState, RewardTermsInSamples};

use crate::EvalError;
use crate::episodes::{Observer, run_episodes};
use crate::shooting::{self, Placement, ShootingOptions};
use crate::subject::Subject;

/// How the episode begins and when it ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shot {
    /// Ball place (x, y) in the robot's first pose `[m]`; `None`: the motion's own.
    pub ball: Option<[f64; 2]>,
    /// Ball velocity `[m/s]`.
    pub velocity: [f64; 2],
    /// Time limit `[s]`.
    pub limit_s: f64,
    /// Index of the motion; `None`: the nearest to the ball, or the first.
    pub motion: Option<usize>,
    /// The observer sees the reward terms.
    pub reward_terms: bool,
}

impl Default for Shot {
    /// The first motion at its own ball for ten seconds.
    fn default() -> Self {
        Self { ball: None, velocity: [0.0; 2], limit_s: 10.0, motion: None, reward_terms: false }
    }
}

/// An episode that was watched.
pub struct Watched<O> {
    /// What the observer kept.
    pub kept: O,
    /// Index of the motion that was followed.
    pub motion: usize,
    /// Half the goal's width `[m]`.
    pub goal_half_width_m: f64,
}

impl Shot {
    /// Plays the episode.
    ///
    /// # Errors
    /// A motion or a ball that the subject does not have, a policy that does not fit.
    pub fn watch<O: Observer>(
        &self,
        subject: &Subject,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Result<Watched<O>, EvalError> {
        if self.ball.is_some() || self.velocity != [0.0; 2] {
            subject.require_ball()?;
        }
        let setup = &subject.setup;
        let nearest = || self.ball.map_or(0, |ball| Placement::new(setup).motion(0, 0, ball, self.velocity));
        let motion = self.motion.unwrap_or_else(nearest);
        let start = InitialState {
            ball_xy: self.ball,
            ball_velocity: self.velocity,
            ..InitialState::nominal(motion)
        };
        let limits = ShootingOptions { limit_s: self.limit_s, ..ShootingOptions::default() };
        let (rules, steps) = shooting::rules_of(&limits, setup.preset.control_dt_s());
        let reward_terms =
            if self.reward_terms { RewardTermsInSamples::Kept } else { RewardTermsInSamples::Dropped };
        let rules = EpisodeRules { reward_terms, ..rules };
        let mut kept = run_episodes(setup, &*subject.maker, &[start], rules, steps, |_| observer(motion))?;
        let (_, kept) = kept.pop().ok_or(EvalError::Stopped)?;
        Ok(Watched { kept, motion, goal_half_width_m: limits.goal_half_width_m })
    }
}
