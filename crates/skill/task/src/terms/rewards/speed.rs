//! Horizontal speed of the ball.

use paid_lanes::{Mask, Real};

use super::kernel::gaussian;
use crate::scene::kick::horizontal2;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Horizontal ball speed: `1 - exp(-v^2 / sigma^2)`, within the window after a correct contact.
    pub struct Speed {
        /// Speed that earns 63%.
        sigma: f64 = 1.2, "m/s", positive, "the authors' public release";
    }
}

impl RewardTerm for Speed {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world, horizontal";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let least = input.config.preset.rewards.kick.min_ball_speed;
        let speed2 = horizontal2(input.state.ball.vel);
        let rewarded = input.kick.window.and(speed2.ge(V::c(least * least)));
        V::select(rewarded, V::one() - gaussian(speed2, self.sigma), V::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Vec3;

    #[test]
    fn horizontal_speed_saturates_and_is_rewarded_within_the_window() {
        let mut fixture = Fixture::new();
        fixture.kick.window = true;
        fixture.state.ball.vel = Vec3([0.0, 1.2, 9.0]);
        close(Speed::default().value(&fixture.input()), 1.0 - (-1.0_f64).exp());
        // The preset's least speed is 0.5 m/s.
        fixture.state.ball.vel = Vec3([0.4, 0.0, 9.0]);
        close(Speed::default().value(&fixture.input()), 0.0);
        fixture.state.ball.vel = Vec3([9.0, 0.0, 0.0]);
        fixture.kick.window = false;
        close(Speed::default().value(&fixture.input()), 0.0);
    }
}
