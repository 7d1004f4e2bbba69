//! How near one leg comes to the other.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// What the gap between the legs lacks: 0 from `margin_m` on, 1 where they touch, more where they overlap. The foot and the next shape
    /// above it (a humanoid's shin) count, against those of the other leg.
    pub struct LegGap {
        /// Gap from which the term is 0.
        margin_m: f64 = 0.03, "m", positive, "MuJoCo's feet are 6 mm wider on each side than the capsules that the legs have in training";
    }
}

impl RewardTerm for LegGap {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "world";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let gap = input.config.lower_legs.gap(input.state);
        (V::one() - gap * V::c(1.0 / self.margin_m)).max(V::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Vec3;

    #[test]
    fn legs_pay_from_the_margin_on_and_feet_side_by_side_are_six_centimeters_wide() {
        let mut fixture = Fixture::new();
        let term = LegGap { weight: 1.0, margin_m: 0.04 };
        for side in 0..2 {
            let foot = fixture.config.foot_body(side);
            let y = if side == 0 { 0.05 } else { -0.05 };
            for body in [foot, foot - 1, foot - 2] {
                fixture.state.bodies[body].pos = Vec3([0.0, y, 0.0]);
            }
            // Shins, which are thicker, are elsewhere.
            fixture.state.bodies[foot - 2].pos = Vec3([0.0, 10.0 * y, 0.4]);
        }
        // Capsules of 3 cm: feet whose middles are 10 cm apart have a gap of 4 cm.
        close(term.value(&fixture.input()), 0.0);
        fixture.foot(0).pos = Vec3([0.0, 0.02, 0.0]);
        close(term.value(&fixture.input()), 0.75);
        fixture.foot(0).pos = Vec3([0.0, -0.01, 0.0]);
        close(term.value(&fixture.input()), 1.5);
    }

    #[test]
    fn a_foot_before_the_other_shin_pays_too() {
        let mut fixture = Fixture::new();
        let [left, right] = [fixture.config.foot_body(0), fixture.config.foot_body(1)];
        for (body, at) in [
            (left, [0.0, 0.0, 0.0]),
            (left - 2, [0.0, 9.0, 0.0]),
            (right, [0.0, -9.0, 0.0]),
            // Its capsule of 4 cm stands at x = 0.02 from 0 to 25 cm below it; the foot's of 3 cm ends at x = 0.112.
            (right - 2, [0.17, 0.0, 0.1]),
        ] {
            fixture.state.bodies[body].pos = Vec3(at);
        }
        // 0.19 - 0.112 - 0.07 m = 8 mm of 40.
        close(LegGap { weight: 1.0, margin_m: 0.04 }.value(&fixture.input()), 0.8);
    }
}
