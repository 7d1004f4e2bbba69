//! Contact with the right foot.

use paid_lanes::Real;

use crate::scene::kick::flag;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// 1 in the step of the episode's first contact with the ball, if it is with the labeled foot.
    pub struct Contact {}
}

impl RewardTerm for Contact {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "none";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        flag(input.kick.paid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;

    #[test]
    fn only_the_labeled_foot_is_rewarded() {
        let mut fixture = Fixture::new();
        fixture.kick.first = true;
        assert_eq!(Contact::default().value(&fixture.input()), 0.0);
        fixture.kick.paid = true;
        assert_eq!(Contact::default().value(&fixture.input()), 1.0);
    }
}
