//! Direction of the ball.

use paid_lanes::{Mask, Real, Vec3};

use super::kernel::gaussian;
use crate::scene::kick::horizontal2;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Angle between the ball's horizontal velocity and the direction from where it lay to the goal: `exp(-angle^2 / sigma^2)`, within
    /// the window after a correct contact.
    pub struct VelAlign {
        /// Width of the kernel.
        sigma: f64 = 0.8, "rad", positive, "the authors' public release";
    }
}

impl RewardTerm for VelAlign {
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "world, horizontal";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let kick = &input.config.preset.rewards.kick;
        let speed2 = horizontal2(input.state.ball.vel);
        let rewarded = input.kick.window.and(speed2.ge(V::c(kick.min_ball_speed * kick.min_ball_speed)));
        let aligned = alignment(input.state.ball.vel, input.ball_before(), input.group.goal, self.sigma);
        V::select(rewarded, aligned * speed_share(speed2.sqrt(), kick.full_ball_speed), V::zero())
    }
}

#[inline(always)]
fn alignment<V: Real>(ball_vel: Vec3<V>, from: Vec3<V>, goal: Vec3<V>, sigma: f64) -> V {
    let (gx, gy) = (goal.x() - from.x(), goal.y() - from.y());
    let cross = gx * ball_vel.y() - gy * ball_vel.x();
    let dot = gx * ball_vel.x() + gy * ball_vel.y();
    let angle = cross.abs().atan2(dot);
    gaussian(angle * angle, sigma)
}

/// Share of the reward that a ball of horizontal `speed` earns: `min(1, speed / full)`, 1 if `full` is 0 `[m/s]`.
#[inline(always)]
fn speed_share<V: Real>(speed: V, full: f64) -> V {
    if full > 0.0 { (speed * V::c(1.0 / full)).min(V::one()) } else { V::one() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn alignment_measures_the_horizontal_angle() {
        let from = Vec3([1.0, 0.0, 0.1]);
        let goal = Vec3([1.0, 5.0, 0.1]);
        close(alignment(Vec3([0.0, 3.0, 2.0]), from, goal, 0.8), 1.0);
        let angle = core::f64::consts::FRAC_PI_4;
        close(alignment(Vec3([2.0, 2.0, 0.0]), from, goal, 0.8), (-(angle * angle) / 0.64).exp());
    }

    #[test]
    fn a_slow_ball_earns_its_share_of_the_direction() {
        close(speed_share(1.0, 2.5), 0.4);
        close(speed_share(4.0, 2.5), 1.0);
        close(speed_share(0.0, 0.0), 1.0);
    }

    #[test]
    fn direction_is_rewarded_within_the_window_above_the_least_speed() {
        let mut fixture = Fixture::new();
        fixture.group.goal = Vec3([0.0, 5.0, 0.1]);
        // The preset's least speed is 0.5 m/s.
        for (window, speed, expected) in [(true, 0.6, 1.0), (true, 0.4, 0.0), (false, 0.6, 0.0)] {
            fixture.kick.window = window;
            fixture.state.ball.vel = Vec3([0.0, speed, 0.0]);
            close(VelAlign::default().value(&fixture.input()), expected);
        }
        fixture.kick.window = true;
        fixture.state.ball.vel = Vec3([0.0, 1.0, 0.0]);
        fixture.config.preset.rewards.kick.full_ball_speed = 4.0;
        close(VelAlign::default().value(&fixture.input()), 0.25);
    }
}
