//! Height of the anchor.

use paid_lanes::Real;

use crate::{Requirement, TermInput, TerminationTerm, parameters};

parameters! {
    /// Difference of the anchor's height from the reference's.
    pub struct AnchorHeight {
        /// Largest difference; 0 switches the term off.
        limit_m: f64 = 0.0, "m", not_negative, "off";
    }
}

impl TerminationTerm for AnchorHeight {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world, vertical";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    fn is_on(&self) -> bool {
        self.limit_m > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        let away = input.anchor().pos.z() - input.group.reference.pos(input.config.anchor).z();
        away.abs().gt(V::c(self.limit_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::Vec3;

    #[test]
    fn too_low_and_too_high_fail() {
        let mut fixture = Fixture::new();
        let term = AnchorHeight { limit_m: 0.25 };
        for (height, fails) in [(0.26, true), (-0.26, true), (0.24, false)] {
            fixture.anchor().pos = Vec3([9.0, 9.0, height]);
            assert_eq!(term.fails(&fixture.input()), fails, "{height}");
        }
    }
}
