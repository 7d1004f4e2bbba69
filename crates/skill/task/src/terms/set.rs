//! The terms of a program: the built-in ones, and those that other crates add.

use std::sync::OnceLock;

use paid_policy::observation::{Observation, ObservationSet, TermSetError};

use super::own::OwnTerm;
use crate::terms::rewards::{REWARD_NAMES, RewardTerm};
use crate::terms::terminations::{TERMINATION_NAMES, TerminationTerm};

static INSTALLED: OnceLock<[Vec<OwnTerm>; 2]> = OnceLock::new();

/// Terms of a program. A crate adds its own in its `main` or test, before a preset is read:
///
/// ```
/// use paid_lanes::Real;
/// use paid_task::{RewardTerm, TermInput, TermSet, reward_term};
///
/// reward_term! {
///     /// Speed of the base toward the goal's side of the world.
///     pub struct Forward {}
/// }
///
/// impl RewardTerm for Forward {
///     const UNIT: &'static str = "m/s";
///     const FRAME: &'static str = "world";
///
///     #[inline(always)]
///     fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
///         input.base().lin_vel.x()
///     }
/// }
///
/// TermSet::builtin().with_reward::<Forward>("forward").install()?;
///
/// let preset = paid_task::TaskPreset::builtin_with("paper_stage1", &["rewards.forward.weight=0.5".to_owned()])?;
/// assert!(paid_task::terms_table().iter().any(|row| row.name == "forward" && row.unit == "m/s"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// From then on the terms stand in presets under their names, are checked, computed, logged and listed as the built-in ones. They are
/// added up after those, in the order in which they were added here.
#[derive(Debug)]
pub struct TermSet {
    observations: ObservationSet,
    rewards: Vec<OwnTerm>,
    terminations: Vec<OwnTerm>,
}

impl TermSet {
    /// The terms of this crate.
    pub fn builtin() -> Self {
        Self { observations: ObservationSet::default(), rewards: Vec::new(), terminations: Vec::new() }
    }

    /// Adds an observation term: presets name it in `observations.policy`, `critic`, `style` and `noise`.
    #[must_use]
    pub fn with_observation<T: Observation>(mut self, name: &'static str) -> Self {
        self.observations = self.observations.with::<T>(name);
        self
    }

    /// Adds a reward term, whose parameters stand in presets under `rewards.<name>`.
    #[must_use]
    pub fn with_reward<T: RewardTerm>(mut self, name: &'static str) -> Self {
        self.rewards.push(OwnTerm::reward::<T>(name));
        self
    }

    /// Adds a termination term, whose limits stand in presets under `terminations.<name>`.
    #[must_use]
    pub fn with_termination<T: TerminationTerm>(mut self, name: &'static str) -> Self {
        self.terminations.push(OwnTerm::termination::<T>(name));
        self
    }

    /// Makes the terms known to the whole program, once.
    ///
    /// # Errors
    /// If a name cannot be used, or terms have been used before, as reading a preset does.
    pub fn install(self) -> Result<(), TermSetError> {
        let names = |terms: &[OwnTerm]| terms.iter().map(|term| term.info.name).collect::<Vec<_>>();
        let reserved = ["body_kernel", "align_yaw", "kick"];
        let taken: Vec<_> = REWARD_NAMES.into_iter().chain(reserved).collect();
        TermSetError::check("reward", &names(&self.rewards), &taken)?;
        let taken: Vec<_> =
            TERMINATION_NAMES.into_iter().chain(["not_finite", "motion_end", "time_out"]).collect();
        TermSetError::check("termination", &names(&self.terminations), &taken)?;
        self.observations.check()?;
        if INSTALLED.get().is_some() {
            return Err(TermSetError::Late);
        }
        self.observations.install()?;
        INSTALLED.set([self.rewards, self.terminations]).map_err(|_| TermSetError::Late)
    }
}

fn installed() -> &'static [Vec<OwnTerm>; 2] {
    INSTALLED.get_or_init(Default::default)
}

/// The installed reward terms in order. From the first call on nothing can be installed.
pub(super) fn own_rewards() -> &'static [OwnTerm] {
    &installed()[0]
}

/// The installed termination terms.
pub(super) fn own_terminations() -> &'static [OwnTerm] {
    &installed()[1]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terms::rewards::Upright;

    #[test]
    fn a_name_that_exists_is_refused_and_so_is_a_set_after_the_first_preset() {
        let error = |name| TermSet::builtin().with_reward::<Upright>(name).install().expect_err("refused");
        for name in ["ball_prox", "kick"] {
            assert_eq!(error(name), TermSetError::Taken { kind: "reward", name });
        }
        crate::TaskPreset::builtin("paper_stage1").expect("valid");
        assert_eq!(error("tilt"), TermSetError::Late);
    }
}
