//! Tilt of the base.

use paid_lanes::Real;
use paid_policy::projected_gravity;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Squared horizontal part of gravity's direction in the base frame: 0 upright, 1 lying.
    pub struct Upright {}
}

impl RewardTerm for Upright {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "base";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let gravity = projected_gravity(&input.state.bodies[0].rot);
        gravity.x().mul_add(gravity.x(), gravity.y() * gravity.y())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Mat3;

    #[test]
    fn a_lying_robot_costs_one_and_an_upright_one_nothing() {
        let mut fixture = Fixture::new();
        close(Upright::default().value(&fixture.input()), 0.0);
        // Gravity in the base frame is minus the third row: (0.6, 0, -0.8).
        fixture.state.bodies[0].rot = Mat3([[0.8, 0.0, 0.6], [0.0, 1.0, 0.0], [-0.6, 0.0, 0.8]]);
        close(Upright::default().value(&fixture.input()), 0.36);
    }
}
