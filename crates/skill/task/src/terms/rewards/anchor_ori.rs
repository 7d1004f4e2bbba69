//! Orientation of the anchor.

use paid_lanes::Real;

use super::kernel::gaussian;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Orientation of the anchor against the reference's, as the angle between them: `exp(-e^2 / sigma^2)`.
    pub struct AnchorOri {
        /// Width of the kernel.
        sigma: f64 = 0.4, "rad", positive, "the authors' public release";
    }
}

impl RewardTerm for AnchorOri {
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let angle = input.tracking.anchor_angle;
        gaussian(angle * angle, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn an_angle_of_two_widths_leaves_exp_of_minus_four() {
        let mut fixture = Fixture::new();
        fixture.tracking.anchor_angle = 0.8;
        close(AnchorOri::default().value(&fixture.input()), (-4.0_f64).exp());
    }
}
