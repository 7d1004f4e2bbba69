//! Orientations of the tracked bodies.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Orientations of the tracked bodies against the yaw-aligned reference: kernel over the bodies.
    pub struct BodyOri {
        /// Width of the kernel.
        sigma: f64 = 0.4, "rad", positive, "the authors' public release";
    }
}

impl RewardTerm for BodyOri {
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "anchor, turned by yaw only";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let errors2 = input.tracking.tracked().iter().map(|body| body.angle * body.angle);
        over_bodies(errors2, input.config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn one_body_at_an_angle_counts_with_its_share() {
        let mut fixture = Fixture::new();
        fixture.tracking.bodies[3].angle = 0.8;
        // Four widths squared, over all tracked bodies.
        close(BodyOri::default().value(&fixture.input()), (-4.0 / fixture.config.tracked as f64).exp());
    }
}
