//! From a policy's action to joint targets: `target = default + offset + scale * action`.

use paid_lanes::Real;

/// Actions are limited to plus and minus this.
pub const ACTION_LIMIT: f64 = 100.0;

/// An action within the limits. NaN becomes the lower limit, so that it cannot reach the joints.
#[inline(always)]
pub fn limit_action<V: Real>(action: V) -> V {
    action.clamp(V::c(-ACTION_LIMIT), V::c(ACTION_LIMIT))
}

/// Target angle of a joint `[rad]`. `scale` is its action scale `[rad]`, `rest` its default angle with the offset of its encoder
/// `[rad]`.
#[inline(always)]
pub fn joint_target<V: Real>(action: V, scale: f64, rest: V) -> V {
    action.mul_add(V::c(scale), rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_action_scales_around_the_rest_angle() {
        assert_eq!(joint_target(2.0, 0.25, -0.1), 0.4);
    }

    #[test]
    fn actions_are_limited_and_a_nan_cannot_pass() {
        assert_eq!(limit_action(7.0), 7.0);
        assert_eq!(limit_action(1e6), ACTION_LIMIT);
        assert_eq!(limit_action(f64::NAN), -ACTION_LIMIT);
    }
}
