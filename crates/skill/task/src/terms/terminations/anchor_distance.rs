//! Place of the anchor on the ground.

use paid_lanes::Real;

use crate::{Requirement, TermInput, TerminationTerm, parameters};

parameters! {
    /// Horizontal distance of the anchor from the reference's.
    pub struct AnchorDistance {
        /// Largest difference; 0 switches the term off.
        limit_m: f64 = 0.0, "m", not_negative, "off";
    }
}

impl TerminationTerm for AnchorDistance {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world, horizontal";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    fn is_on(&self) -> bool {
        self.limit_m > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        let away = input.anchor().pos - input.group.reference.pos(input.config.anchor);
        away.x().mul_add(away.x(), away.y() * away.y()).gt(V::c(self.limit_m * self.limit_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::Vec3;

    #[test]
    fn only_the_horizontal_distance_counts() {
        let mut fixture = Fixture::new();
        let term = AnchorDistance { limit_m: 0.5 };
        for (place, fails) in [([0.3, 0.41, 0.0], true), ([0.3, 0.39, 9.0], false)] {
            fixture.anchor().pos = Vec3(place);
            assert_eq!(term.fails(&fixture.input()), fails, "{place:?}");
        }
    }
}
