//! Change of the action.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Squared change of the action since the last step, summed over joints.
    pub struct ActionRate {
        /// Largest value before weighting.
        clip: f64 = 100.0, "", not_negative, "keeps the first random actions of a training from ruling the return";
    }
}

impl RewardTerm for ActionRate {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "joint";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let joints = 0..input.config.joints();
        squared_change(joints, &input.group.action, &input.group.previous).min(V::c(self.clip))
    }
}

/// Squared change of the given joints' actions, summed.
#[inline(always)]
pub(super) fn squared_change<V: Real>(
    joints: impl Iterator<Item = usize>,
    action: &[V],
    previous: &[V],
) -> V {
    let mut sum = V::zero();
    for j in joints {
        let change = action[j] - previous[j];
        sum += change * change;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;

    #[test]
    fn changes_are_squared_summed_and_clipped() {
        let mut fixture = Fixture::new();
        fixture.group.action[2] = 1.5;
        fixture.group.previous[2] = -0.5;
        fixture.group.action[5] = 1.0;
        assert_eq!(ActionRate::default().value(&fixture.input()), 5.0);
        fixture.group.action[5] = 30.0;
        assert_eq!(ActionRate::default().value(&fixture.input()), 100.0);
    }
}
