//! Joints outside their soft limits.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// Distance of the joints outside their soft limits, summed.
    pub struct JointLimit {}
}

impl RewardTerm for JointLimit {
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "joint";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let mut sum = V::zero();
        for (&angle, &[lo, hi]) in input.state.joint_pos.iter().zip(&input.config.control.soft_range) {
            sum += (V::c(lo) - angle).max(V::zero()) + (angle - V::c(hi)).max(V::zero());
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn both_sides_count() {
        let mut fixture = Fixture::new();
        fixture.config.control.soft_range.fill([-1.0, 1.0]);
        close(JointLimit::default().value(&fixture.input()), 0.0);
        fixture.state.joint_pos[0] = 1.5;
        fixture.state.joint_pos[7] = -1.25;
        close(JointLimit::default().value(&fixture.input()), 0.75);
    }
}
