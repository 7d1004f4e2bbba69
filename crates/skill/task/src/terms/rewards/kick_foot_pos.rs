//! Position of the kicking foot.

use paid_lanes::Real;

use super::kernel::around_strike;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Position of the labeled kicking foot against the yaw-aligned reference: kernel. This project's own.
    pub struct KickFootPos {
        /// Width of the kernel.
        sigma: f64 = 0.2, "m", positive, "narrower than the 0.3 m of both feet";
        /// The term counts within this time before and after the reference's strike; 0: over the whole motion.
        around_s: f64 = 0.0, "s", not_negative, "over the whole motion";
    }
}

impl RewardTerm for KickFootPos {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor, turned by yaw only";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let [left, right] = input.config.feet.map(|foot| input.tracking.bodies[foot].pos2);
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
        fixture.tracking.bodies[left].pos2 = 0.2 * 0.2;
        fixture.tracking.bodies[right].pos2 = 4.0 * 0.2 * 0.2;
        for (label, to_strike_s, expected) in
            [(-1.0, 0.2, (-1.0_f64).exp()), (1.0, -0.2, (-4.0_f64).exp()), (1.0, 0.4, 0.0)]
        {
            (fixture.group.kick.label, fixture.group.to_strike_s) = (label, to_strike_s);
            let term = KickFootPos { around_s: 0.3, ..KickFootPos::default() };
            close(term.value(&fixture.input()), expected);
        }
    }
}
