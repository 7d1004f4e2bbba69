//! Positions of the tracked bodies.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Positions of the tracked bodies against the yaw-aligned reference: kernel over the bodies.
    pub struct BodyPos {
        /// Width of the kernel.
        sigma: f64 = 0.3, "m", positive, "the authors' public release";
        /// True: the feet are left out, for a stage in which they have a term of their own.
        exclude_feet: bool = false, "", switch, "the first stage tracks every body with one term";
    }
}

impl RewardTerm for BodyPos {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor, turned by yaw only";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let config = input.config;
        let bodies = input.tracking.tracked().iter().enumerate();
        let counted = bodies.filter(|(i, _)| !(self.exclude_feet && config.feet.contains(i)));
        over_bodies(counted.map(|(_, body)| body.pos2), config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn the_feet_count_unless_they_are_left_out() {
        let mut fixture = Fixture::new();
        let tracked = fixture.config.tracked;
        let left = fixture.config.feet[0];
        fixture.tracking.bodies[left].pos2 = 0.09 * tracked as f64;
        let term = BodyPos { exclude_feet: false, ..BodyPos::default() };
        close(term.value(&fixture.input()), (-1.0_f64).exp());
        let term = BodyPos { exclude_feet: true, ..term };
        close(term.value(&fixture.input()), 1.0);
    }
}
