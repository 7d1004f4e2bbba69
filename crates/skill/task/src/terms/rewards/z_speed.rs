//! Vertical speed of the ball.

use paid_lanes::Real;

use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Vertical ball speed: `tanh(|v_z| / sigma)`, within the window after the touched ball first moves.
    pub struct ZSpeed {
        /// Speed that earns 76%.
        sigma: f64 = 3.0, "m/s", positive, "the authors' public release";
    }
}

impl RewardTerm for ZSpeed {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world, vertical";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let vertical = (input.state.ball.vel.z().abs() * V::c(1.0 / self.sigma)).tanh();
        V::select(input.kick.z_window, vertical, V::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Vec3;

    #[test]
    fn vertical_speed_saturates_and_counts_within_its_window() {
        let mut fixture = Fixture::new();
        fixture.state.ball.vel = Vec3([9.0, 9.0, -3.0]);
        close(ZSpeed::default().value(&fixture.input()), 0.0);
        fixture.kick.z_window = true;
        close(ZSpeed::default().value(&fixture.input()), 1.0_f64.tanh());
    }
}
