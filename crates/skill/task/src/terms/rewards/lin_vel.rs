//! Velocities of the tracked bodies' centers of mass.

use paid_lanes::Real;

use super::kernel::over_bodies;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Velocities of the tracked bodies' centers of mass against the reference: kernel over the bodies.
    pub struct LinVel {
        /// Width of the kernel.
        sigma: f64 = 1.0, "m/s", positive, "the authors' public release";
    }
}

impl RewardTerm for LinVel {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let errors2 = input.tracking.tracked().iter().map(|body| body.lin2);
        over_bodies(errors2, input.config.preset.rewards.body_kernel, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::BodyKernel;
    use crate::fixture::{Fixture, close};

    #[test]
    fn the_preset_chooses_the_kernel_over_the_bodies() {
        let mut fixture = Fixture::new();
        let n = fixture.config.tracked as f64;
        fixture.tracking.bodies[0].lin2 = 2.0;
        close(LinVel::default().value(&fixture.input()), (-2.0 / n).exp());
        fixture.config.preset.rewards.body_kernel = BodyKernel::MeanOfExp;
        close(LinVel::default().value(&fixture.input()), (n - 1.0 + (-2.0_f64).exp()) / n);
    }
}
