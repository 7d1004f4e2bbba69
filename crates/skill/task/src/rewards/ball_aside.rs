//! Sideways speed of the ball.

use paid_lanes::{Real, Vec3};

use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Speed of the ball across the way from where it lay to the goal, within the window after a correct contact; for a penalty. This
    /// project's own.
    pub struct BallAside {}
}

impl RewardTerm for BallAside {
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "world, horizontal";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let aside = speed_aside(input.state.ball.vel, input.group.goal - input.ball_before());
        V::select(input.kick.window, aside, V::zero())
    }
}

/// Horizontal speed across `way` `[m/s]`.
#[inline(always)]
fn speed_aside<V: Real>(ball_vel: Vec3<V>, way: Vec3<V>) -> V {
    let cross = way.x() * ball_vel.y() - way.y() * ball_vel.x();
    let length = way.x().mul_add(way.x(), way.y() * way.y()).sqrt();
    cross.abs() / length.max(V::c(1e-6))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn the_part_across_the_way_to_the_goal_counts_within_the_window() {
        let mut fixture = Fixture::new();
        fixture.group.kick.before = Vec3([1.0, 1.0, 0.1]);
        fixture.group.goal = Vec3([4.0, 5.0, 0.1]);
        // The way is (0.6, 0.8): 3 (-0.8, 0.6) + 2 (0.6, 0.8) is 3 m/s across it, whatever the height.
        fixture.state.ball.vel = Vec3([3.0 * -0.8 + 2.0 * 0.6, 3.0 * 0.6 + 2.0 * 0.8, 7.0]);
        close(BallAside::default().value(&fixture.input()), 0.0);
        fixture.kick.window = true;
        close(BallAside::default().value(&fixture.input()), 3.0);
        fixture.state.ball.vel = Vec3([0.6, 0.8, 0.0]);
        close(BallAside::default().value(&fixture.input()), 0.0);
    }
}
