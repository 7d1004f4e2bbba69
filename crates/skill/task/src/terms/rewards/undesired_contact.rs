//! Contacts that should not be.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Number of bodies that touch something although the robot's description does not allow it.
    pub struct UndesiredContact {
        /// Force from which a contact counts.
        force_n: f64 = 1.0, "N", not_negative, "the authors' public release";
    }
}

impl RewardTerm for UndesiredContact {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "none";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let mut count = V::zero();
        for &body in &input.config.undesired {
            let touches = input.state.contact_force[body].norm().gt(V::c(self.force_n));
            count += V::select(touches, V::one(), V::zero());
        }
        count
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::Vec3;

    #[test]
    fn each_body_that_touches_counts_once() {
        let mut fixture = Fixture::new();
        let [first, second] = [fixture.config.undesired[0], fixture.config.undesired[1]];
        fixture.state.contact_force[first] = Vec3([0.0, 1.01, 0.0]);
        fixture.state.contact_force[second] = Vec3([0.0, 0.0, 0.99]);
        let foot = fixture.config.followed[fixture.config.feet[0]];
        fixture.state.contact_force[foot] = Vec3([0.0, 0.0, 300.0]);
        assert_eq!(UndesiredContact::default().value(&fixture.input()), 1.0);
    }
}
