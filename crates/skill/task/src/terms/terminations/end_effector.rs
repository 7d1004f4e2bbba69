//! Heights of hands and feet.

use paid_lanes::Real;

use crate::{Requirement, TermInput, TerminationTerm, parameters};

parameters! {
    /// Largest difference of an end effector's height from the reference's.
    pub struct EndEffector {
        /// Largest difference; 0 switches the term off.
        limit_m: f64 = 0.0, "m", not_negative, "off";
    }
}

impl TerminationTerm for EndEffector {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world, vertical";
    const NEEDS: &'static [Requirement] = &[Requirement::Reference];

    fn is_on(&self) -> bool {
        self.limit_m > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        let mut largest = V::zero();
        for &i in &input.config.end_effectors {
            // Alignment is a turn about z: the aligned target's height is the reference's.
            let lift =
                input.state.bodies[input.config.followed[i]].pos.z() - input.group.reference.pos(i).z();
            largest = largest.max(lift.abs());
        }
        largest.gt(V::c(self.limit_m))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::Vec3;

    #[test]
    fn one_end_effector_is_enough() {
        let mut fixture = Fixture::new();
        let term = EndEffector { limit_m: 0.25 };
        assert!(!term.fails(&fixture.input()));
        let last = *fixture.config.end_effectors.last().expect("some");
        fixture.state.bodies[fixture.config.followed[last]].pos = Vec3([0.0, 0.0, -0.26]);
        assert!(term.fails(&fixture.input()));
    }
}
