//! Positions of the hands.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Positions of the end effectors that are not feet against the yaw-aligned reference: kernel over them. This project's own.
    pub struct HandPos {
        /// Width of the kernel.
        sigma: f64 = 0.1, "m", positive, "once the feet are in place, the arms hold most of what is left of the mean error over the bodies";
    }
}

impl RewardTerm for HandPos {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor, turned by yaw only";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let config = input.config;
        let hands = config.end_effectors.iter().filter(|i| !config.feet.contains(i));
        let errors2 = hands.map(|&hand| input.tracking.bodies[hand].pos2);
        over_bodies(errors2, config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn hands_count_and_feet_do_not() {
        let mut fixture = Fixture::new();
        for i in 0..fixture.tracking.bodies.len() {
            let config = &fixture.config;
            let hand = config.end_effectors.contains(&i) && !config.feet.contains(&i);
            fixture.tracking.bodies[i].pos2 = if hand { 0.01 } else { 5.0 };
        }
        close(HandPos::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
