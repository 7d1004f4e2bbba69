//! Touching the ball again.

use paid_lanes::{Mask, Real};

use crate::kick::is_set;
use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// 1 while the robot touches the ball again, later than `after_s` after the first contact; for a penalty. This project's own.
    pub struct SecondTouch {
        /// From this time after the first contact on a contact is another one.
        after_s: f64 = 0.1, "s", not_negative, "a soft ball stays on the foot for 40 ms, and rolls off it";
    }
}

impl RewardTerm for SecondTouch {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "none";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let (kick, config) = (&input.group.kick, input.config);
        let least = V::c(config.preset.rewards.kick.contact_force_n);
        let touches = input.state.ball.robot_force.norm().gt(least);
        let later = kick.since.gt(V::c(self.after_s / config.dt_s));
        V::select(touches.and(later).and(is_set(kick.touched)), V::one(), V::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::Vec3;

    #[test]
    fn a_contact_counts_from_its_time_after_the_first_one_on() {
        let mut fixture = Fixture::new();
        // The preset's least force is 10 N, a control step is 20 ms.
        for (touched, since, force, expected) in [
            (1.0, 6.0, 12.0, 1.0),
            (1.0, 5.0, 12.0, 0.0),
            (1.0, 6.0, 9.0, 0.0),
            (1.0, 0.0, 12.0, 0.0),
            (0.0, 6.0, 12.0, 0.0),
        ] {
            (fixture.group.kick.touched, fixture.group.kick.since) = (touched, since);
            fixture.state.ball.robot_force = Vec3([0.0, force, 0.0]);
            close(SecondTouch::default().value(&fixture.input()), expected);
        }
    }
}
