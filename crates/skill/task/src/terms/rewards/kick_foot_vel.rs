//! Velocity of the kicking foot.

use paid_lanes::Real;

use super::kernel::around_strike;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Velocity of the labeled kicking foot's center of mass against the reference's: kernel. This project's own.
    pub struct KickFootVel {
        /// Width of the kernel.
        sigma: f64 = 2.0, "m/s", positive, "the mean over all bodies gives one ankle 1/14 of the pull that the action rate costs at the strike";
        /// The term counts within this time before and after the reference's strike; 0: over the whole motion.
        around_s: f64 = 0.0, "s", not_negative, "over the whole motion";
    }
}

impl RewardTerm for KickFootVel {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let [left, right] = input.config.feet.map(|foot| input.tracking.bodies[foot].lin2);
        let error2 = V::select(input.group.kick.label.gt(V::zero()), right, left);
        around_strike(error2, input.group.to_strike_s, self.sigma, self.around_s)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn only_the_labeled_foot_counts_and_only_around_the_strike() {
        let mut fixture = Fixture::new();
        let [left, right] = fixture.config.feet;
        fixture.tracking.bodies[left].lin2 = 2.0 * 2.0;
        fixture.tracking.bodies[right].lin2 = 4.0 * 2.0 * 2.0;
        for (label, to_strike_s, expected) in
            [(-1.0, 0.2, (-1.0_f64).exp()), (1.0, -0.2, (-4.0_f64).exp()), (1.0, 0.4, 0.0)]
        {
            (fixture.group.kick.label, fixture.group.to_strike_s) = (label, to_strike_s);
            let term = KickFootVel { around_s: 0.3, ..KickFootVel::default() };
            close(term.value(&fixture.input()), expected);
        }
    }
}
