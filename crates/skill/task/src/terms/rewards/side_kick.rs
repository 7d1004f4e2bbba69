//! Direction of the kicking foot.

use paid_lanes::{Real, Vec3};

use crate::{Requirement, RewardTerm, TermInput, reward_term};

reward_term! {
    /// Share of the kicking foot's speed that swings inwards, in the step of a correct first contact.
    pub struct SideKick {}
}

impl RewardTerm for SideKick {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "foot";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let [left, right] = [input.foot(0), input.foot(1)];
        let left = inward_share(left.rot.tr_mul_vec(left.com_vel), V::c(-1.0));
        let right = inward_share(right.rot.tr_mul_vec(right.com_vel), V::c(1.0));
        V::select(input.kick.correct, V::select(input.kick.right, right, left), V::zero())
    }
}

/// `max(0, v_y s) / |v|`, v in the foot's axes, s = -1 for the left and +1 for the right foot; 0 for a resting foot.
#[inline(always)]
fn inward_share<V: Real>(foot_vel_in_foot: Vec3<V>, side: V) -> V {
    let speed = foot_vel_in_foot.norm();
    let lateral = (foot_vel_in_foot.y() * side).max(V::zero());
    V::select(speed.gt(V::c(1e-4)), lateral / speed.max(V::c(1e-4)), V::zero())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn a_side_kick_swings_inwards() {
        close(inward_share(Vec3([3.0, 4.0, 0.0]), 1.0), 0.8);
        close(inward_share(Vec3([3.0, 4.0, 0.0]), -1.0), 0.0);
        close(inward_share(Vec3([3.0, -4.0, 0.0]), -1.0), 0.8);
        close(inward_share(Vec3([0.0; 3]), 1.0), 0.0);
    }

    #[test]
    fn the_kicking_foot_is_rewarded_at_the_contact_only() {
        let mut fixture = Fixture::new();
        fixture.foot(0).com_vel = Vec3([4.0, -3.0, 0.0]);
        fixture.foot(1).com_vel = Vec3([3.0, 4.0, 0.0]);
        close(SideKick::default().value(&fixture.input()), 0.0);
        fixture.kick.correct = true;
        close(SideKick::default().value(&fixture.input()), 0.6);
        fixture.kick.right = true;
        close(SideKick::default().value(&fixture.input()), 0.8);
    }
}
