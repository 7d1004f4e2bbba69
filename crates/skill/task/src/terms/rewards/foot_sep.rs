//! Distance of the feet from one another.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Distance between the feet: 1 from `distance_m`, below it `exp(-(d / distance_m - 1)^2 / sigma^2)`.
    pub struct FootSep {
        /// Distance from which the term is 1.
        distance_m: f64 = 0.24, "m", positive, "the authors' public release";
        /// Width relative to the distance.
        sigma: f64 = 0.5, "", positive, "the authors' public release";
    }
}

impl RewardTerm for FootSep {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let apart = (input.foot(0).pos - input.foot(1).pos).norm();
        let lack = (apart * V::c(1.0 / self.distance_m) - V::one()).min(V::zero());
        (lack * lack * V::c(-1.0 / (self.sigma * self.sigma))).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Vec3;

    #[test]
    fn feet_are_free_from_the_distance() {
        let mut fixture = Fixture::new();
        fixture.foot(0).pos = Vec3([0.0, 0.12, 0.05]);
        fixture.foot(1).pos = Vec3([0.0, -0.13, 0.05]);
        assert_eq!(FootSep::default().value(&fixture.input()), 1.0);
        // Half the distance is lacking: one width.
        fixture.foot(1).pos = Vec3([0.0, 0.0, 0.05]);
        close(FootSep::default().value(&fixture.input()), (-1.0_f64).exp());
    }
}
