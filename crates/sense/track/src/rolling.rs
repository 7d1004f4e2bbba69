//! Where a rolling ball will be.

use paid_lanes::{Real, Vec3};

/// A ball faster than this has been kicked; it is predicted as far as a ball at this speed `[m/s]`.
const FASTEST: f64 = 0.6;

/// Rate at which a ball that rolls without sliding slows down `[1/s]`. Linear damping `c_v` and angular damping `c_w` act on
/// one motion with `v = w r`: `(1 + k) v' = -(c_v + k c_w) v`, where `k` is the moment of inertia over `m r^2`.
pub fn roll_decay(inertia_factor: f64, linear_damping: f64, angular_damping: f64) -> f64 {
    (linear_damping + inertia_factor * angular_damping) / (1.0 + inertia_factor)
}

/// How long a ball at constant speed takes for the distance that a ball with `decay` `[1/s]` rolls within `wait` `[s]`:
/// `(1 - exp(-decay wait)) / decay` `[s]`. A negative `wait` counts as 0.
#[inline(always)]
pub fn effective_time<V: Real>(wait: V, decay: V) -> V {
    let wait = wait.max(V::zero());
    let free = (decay * wait).lt(V::c(1e-6));
    let damped = (V::one() - (-decay * wait).exp()) / V::select(free, V::one(), decay);
    V::select(free, wait, damped)
}

/// Horizontal displacement of a ball with velocity `vel` `[m/s]` within an [`effective_time`] `[s]`, in the axes of `vel` (z up)
/// `[m]`.
#[inline(always)]
pub fn predicted_displacement<V: Real>(vel: Vec3<V>, effective_time: V) -> Vec3<V> {
    let speed = vel.x().mul_add(vel.x(), vel.y() * vel.y()).sqrt();
    let scale = effective_time * (V::c(FASTEST) / speed.max(V::c(FASTEST)));
    Vec3([vel.x() * scale, vel.y() * scale, V::zero()])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_damped_ball_comes_to_rest_and_an_undamped_one_does_not() {
        assert_eq!(effective_time(2.0, 0.0), 2.0);
        assert!((effective_time(2.0, 1e-7) - 2.0_f64).abs() < 1e-6);
        assert!((effective_time(100.0, 1.7) - 1.0_f64 / 1.7).abs() < 1e-12);
        assert!((effective_time(1.0, 2.0) - 0.5 * (1.0 - (-2.0_f64).exp())).abs() < 1e-12);
        assert_eq!(effective_time(-1.0, 0.5), 0.0);
    }

    #[test]
    fn both_dampings_slow_a_shell_as_one() {
        let decay = roll_decay(2.0 / 3.0, 0.5, 2.0);
        assert!((decay - (0.5 + 4.0 / 3.0) / (5.0 / 3.0)).abs() < 1e-12);
    }

    #[test]
    fn a_kicked_ball_is_not_predicted_to_the_horizon() {
        let slow = predicted_displacement::<f64>(Vec3([0.3, -0.4, 1.0]), 2.0).0;
        assert!((slow[0] - 0.6).abs() < 1e-12 && (slow[1] + 0.8).abs() < 1e-12 && slow[2] == 0.0);
        let fast = predicted_displacement::<f64>(Vec3([6.0, 0.0, 0.0]), 2.0).0;
        assert!((fast[0] - 1.2).abs() < 1e-12);
    }
}
