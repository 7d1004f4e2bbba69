//! Angular velocities of the tracked bodies.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Angular velocities of the tracked bodies against the reference: kernel over the bodies.
    pub struct AngVel {
        /// Width of the kernel.
        sigma: f64 = 3.14, "rad/s", positive, "the authors' public release";
    }
}

impl RewardTerm for AngVel {
    const UNIT: &'static str = "rad/s";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let errors2 = input.tracking.tracked().iter().map(|body| body.ang2);
        over_bodies(errors2, input.config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn all_bodies_off_by_one_width_leave_one_in_e() {
        let mut fixture = Fixture::new();
        let tracked = fixture.config.tracked;
        for body in &mut fixture.tracking.bodies[..tracked] {
            body.ang2 = 3.14 * 3.14;
        }
        close(AngVel::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
