//! Position of the anchor.

use paid_lanes::Real;

use super::kernel::gaussian;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Position of the anchor against the reference's: `exp(-e^2 / sigma^2)`.
    pub struct AnchorPos {
        /// Width of the kernel.
        sigma: f64 = 0.3, "m", positive, "the authors' public release";
    }
}

impl RewardTerm for AnchorPos {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        gaussian(input.tracking.anchor_pos2, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn an_error_of_one_width_leaves_one_in_e() {
        let mut fixture = Fixture::new();
        fixture.tracking.anchor_pos2 = 0.09;
        close(AnchorPos::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
