//! Where a rolling ball will be when the reference strikes.

use paid_lanes::{Real, Vec3};
use paid_physics::BallParams;

/// A ball faster than this has been kicked; predictions go no further than at this speed [m/s].
const FASTEST: f64 = 0.6;

/// Rate at which a ball that rolls without sliding slows down [1/s]. Linear damping `c_v` and angular damping `c_w` act on one motion
/// with `v = w r`: `(1 + k) v' = -(c_v + k c_w) v` with `k` the inertia factor.
pub fn roll_decay(ball: &BallParams) -> f64 {
    let k = ball.inertia_factor;
    (ball.linear_damping + k * ball.angular_damping) / (1.0 + k)
}

/// Way of a rolling ball within `wait_s`, as a multiple of its velocity [s]: `(1 - exp(-c t)) / c`.
pub(crate) fn way_s(wait_s: f64, decay: f64) -> f64 {
    let wait = wait_s.max(0.0);
    if decay * wait < 1e-6 { wait } else { (1.0 - (-decay * wait).exp()) / decay }
}

/// Horizontal way of a ball with velocity `vel` [m/s], world axes [m]; `lead_s` is [`way_s`].
#[inline(always)]
pub(crate) fn way<V: Real>(vel: Vec3<V>, lead_s: V) -> Vec3<V> {
    let speed = vel.x().mul_add(vel.x(), vel.y() * vel.y()).sqrt();
    let scale = lead_s * (V::c(FASTEST) / speed.max(V::c(FASTEST)));
    Vec3([vel.x() * scale, vel.y() * scale, V::zero()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_ball_comes_to_rest_and_an_undamped_one_does_not() {
        assert_eq!(way_s(2.0, 0.0), 2.0);
        assert!((way_s(2.0, 1e-7) - 2.0).abs() < 1e-6);
        assert!((way_s(100.0, 1.7) - 1.0 / 1.7).abs() < 1e-12);
        assert!((way_s(1.0, 2.0) - 0.5 * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
        assert_eq!(way_s(-1.0, 0.5), 0.0);
    }

    #[test]
    fn both_dampings_slow_a_shell_as_one() {
        let ball = BallParams { linear_damping: 0.5, angular_damping: 2.0, ..BallParams::default() };
        assert!((ball.inertia_factor - 2.0 / 3.0).abs() < 1e-12);
        assert!((roll_decay(&ball) - (0.5 + 4.0 / 3.0) / (5.0 / 3.0)).abs() < 1e-12);
    }

    #[test]
    fn a_kicked_ball_is_not_led_to_the_horizon() {
        let slow = way::<f64>(Vec3([0.3, -0.4, 1.0]), 2.0).0;
        assert!((slow[0] - 0.6).abs() < 1e-12 && (slow[1] + 0.8).abs() < 1e-12 && slow[2] == 0.0);
        let fast = way::<f64>(Vec3([6.0, 0.0, 0.0]), 2.0).0;
        assert!((fast[0] - 1.2).abs() < 1e-12);
    }
}
