//! Change of the waist's action.

use paid_lanes::Real;

use super::action_rate::squared_change;
use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Squared change of the waist joints' action since the last step, summed.
    pub struct WaistRate {
        /// Largest value before weighting.
        clip: f64 = 100.0, "", not_negative, "keeps the first random actions of a training from ruling the return";
    }
}

impl RewardTerm for WaistRate {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "joint";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let waist = input.config.waist.iter().copied();
        squared_change(waist, &input.group.action, &input.group.previous).min(V::c(self.clip))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;

    #[test]
    fn only_the_waist_counts() {
        let mut fixture = Fixture::new();
        fixture.group.action.fill(2.0);
        let expected = 4.0 * fixture.config.waist.len() as f64;
        assert_eq!((WaistRate::default().value(&fixture.input()), expected), (12.0, 12.0));
    }
}
