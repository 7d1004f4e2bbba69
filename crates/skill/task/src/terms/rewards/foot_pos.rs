//! Positions of the feet.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Positions of both feet against the yaw-aligned reference: kernel over the feet.
    pub struct FootPos {
        /// Width of the kernel.
        sigma: f64 = 0.3, "m", positive, "the authors' public release";
    }
}

impl RewardTerm for FootPos {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor, turned by yaw only";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let errors2 = input.config.feet.iter().map(|&foot| input.tracking.bodies[foot].pos2);
        over_bodies(errors2, input.config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn each_foot_counts_half() {
        let mut fixture = Fixture::new();
        let [left, _] = fixture.config.feet;
        fixture.tracking.bodies[left].pos2 = 0.18;
        close(FootPos::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
