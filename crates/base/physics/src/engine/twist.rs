//! Torsional and rolling friction of the ball.

use paid_lanes::{Real, Vec3};

/// Angular impulses at a contact of the ball, on their way through the sweeps. The other body does not feel them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Twist<V> {
    /// Angular velocity that a contact without limit leaves the ball.
    target: Vec3<V>,
    /// On the ball so far `[N m s]`.
    impulse: Vec3<V>,
}

impl<V: Real> Twist<V> {
    pub fn zero() -> Self {
        Self { target: Vec3::zero(), impulse: Vec3::zero() }
    }

    /// The contact of a ball that turns by `ball` with a body that turns by `body` `[rad/s]`; `keep` is the share of the
    /// difference that stays over the step.
    #[inline(always)]
    pub fn start(body: Vec3<V>, ball: Vec3<V>, keep: V) -> Self {
        Self { target: (ball - body).scale_add(keep, body), impulse: Vec3::zero() }
    }

    /// One improvement: about the normal `n` within `friction[0]`, across it within `friction[1]` times the normal impulse.
    #[inline(always)]
    pub fn improve(&mut self, n: Vec3<V>, friction: &[V; 2], normal: V, inv_inertia: V, omega: &mut Vec3<V>) {
        let wanted = (self.target - *omega).scale_add(inv_inertia.recip(), self.impulse);
        let about = wanted.dot(n);
        let across = wanted - n.scale(about);
        let most = friction[0] * normal;
        let about = about.min(most).max(-most);
        let inv_length = (across.norm2() + V::c(1e-12)).rsqrt();
        let scale = (friction[1] * normal * inv_length).min(V::one());
        let impulse = n.scale_add(about, across.scale(scale));
        *omega = (impulse - self.impulse).scale_add(inv_inertia, *omega);
        self.impulse = impulse;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spin_about_the_normal_is_braked_within_its_limit() {
        let mut omega = Vec3([0.0, 0.0, 10.0]);
        let mut twist = Twist::start(Vec3([0.0; 3]), omega, 0.0);
        // 0.01 m x 2 N s over 0.005 kg m^2: 4 rad/s, however often it is improved.
        for _ in 0..3 {
            twist.improve(Vec3([0.0, 0.0, 1.0]), &[0.01, 0.0], 2.0, 200.0, &mut omega);
        }
        assert!((omega.0[2] - 6.0).abs() < 1e-12, "{omega:?}");
    }

    #[test]
    fn a_slow_roll_stops_and_does_not_turn_back() {
        let mut omega = Vec3([0.3, 0.0, 5.0]);
        let mut twist = Twist::start(Vec3([0.0; 3]), omega, 0.0);
        twist.improve(Vec3([0.0, 0.0, 1.0]), &[0.0, 0.01], 2.0, 200.0, &mut omega);
        assert!(omega.0[0].abs() < 1e-9 && (omega.0[2] - 5.0).abs() < 1e-9, "{omega:?}");
    }
}
