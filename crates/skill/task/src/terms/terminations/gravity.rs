//! Tilt of the anchor.

use paid_lanes::Real;
use paid_policy::projected_gravity;

use crate::{Requirement, TermInput, TerminationTerm, parameters};

parameters! {
    /// Difference of the z component of gravity in the anchor's frame from the reference's.
    pub struct Gravity {
        /// Largest difference; 0 switches the term off.
        limit: f64 = 0.0, "", not_negative, "off";
    }
}

impl TerminationTerm for Gravity {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "anchor";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    fn is_on(&self) -> bool {
        self.limit > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        let target = input.group.reference.rot(input.config.anchor);
        let away = projected_gravity(&input.anchor().rot).z() - projected_gravity(&target).z();
        away.abs().gt(V::c(self.limit))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::Quat;

    #[test]
    fn a_tilt_of_more_than_78_degrees_fails_at_a_limit_of_0_8() {
        let mut fixture = Fixture::new();
        let term = Gravity { limit: 0.8 };
        for (degrees, fails) in [(80.0_f64, true), (78.0, false), (-80.0, true)] {
            fixture.anchor().rot = Quat::from_roll_pitch_yaw(degrees.to_radians(), 0.0, 1.0).to_mat();
            assert_eq!(term.fails(&fixture.input()), fails, "{degrees}");
        }
    }
}
