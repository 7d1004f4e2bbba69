//! Velocities of the feet.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Velocities of both feet's centers of mass against the reference's: kernel over the feet. This project's own.
    pub struct FeetVel {
        /// Width of the kernel.
        sigma: f64 = 2.0, "m/s", positive, "about 40% of the fastest kick's foot speed";
    }
}

impl RewardTerm for FeetVel {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let errors2 = input.config.feet.iter().map(|&foot| input.tracking.bodies[foot].lin2);
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
        let [_, right] = fixture.config.feet;
        fixture.tracking.bodies[right].lin2 = 8.0;
        close(FeetVel::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
