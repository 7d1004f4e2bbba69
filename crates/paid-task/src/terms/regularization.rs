//! Terms that keep the motion clean.

use paid_lanes::{Real, Vec3};

/// Square of a change of one action.
#[inline(always)]
pub(crate) fn squared_change<V: Real>(action: V, previous: V) -> V {
    let change = action - previous;
    change * change
}

/// Distance outside `[lo, hi]`.
#[inline(always)]
pub(crate) fn outside<V: Real>(value: V, lo: f64, hi: f64) -> V {
    (V::c(lo) - value).max(V::zero()) + (value - V::c(hi)).max(V::zero())
}

/// 1 if a contact force is above the limit.
#[inline(always)]
pub(crate) fn touches<V: Real>(force: V, limit_n: f64) -> V {
    V::select(force.gt(V::c(limit_n)), V::one(), V::zero())
}

/// 1 when the feet are at least `distance` apart, else `exp(-(d / distance - 1)^2 / sigma^2)`.
#[inline(always)]
pub(crate) fn foot_separation<V: Real>(left: Vec3<V>, right: Vec3<V>, distance: f64, sigma: f64) -> V {
    let lack = ((left - right).norm() * V::c(1.0 / distance) - V::one()).min(V::zero());
    (lack * lack * V::c(-1.0 / (sigma * sigma))).exp()
}

/// Squared horizontal part of gravity in a frame: 0 upright, 1 lying.
#[inline(always)]
pub(crate) fn tilt<V: Real>(gravity: Vec3<V>) -> V {
    gravity.x().mul_add(gravity.x(), gravity.y() * gravity.y())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_by_hand() {
        assert_eq!(squared_change(1.5, -0.5), 4.0);
        assert_eq!(
            [outside(1.5, -1.0, 1.0), outside(-1.25, -1.0, 1.0), outside(0.0, -1.0, 1.0)],
            [0.5, 0.25, 0.0]
        );
        assert_eq!([touches(1.01, 1.0), touches(0.99, 1.0)], [1.0, 0.0]);
        assert_eq!(tilt(Vec3([0.6, 0.0, -0.8])), 0.36);
    }

    #[test]
    fn feet_are_free_from_a_distance_on() {
        let left = Vec3([0.0, 0.12, 0.05]);
        assert_eq!(foot_separation(left, Vec3([0.0, -0.13, 0.05]), 0.24, 0.5), 1.0);
        let crossed: f64 = foot_separation(left, Vec3([0.0, 0.0, 0.05]), 0.24, 0.5);
        assert!((crossed - (-1.0_f64).exp()).abs() < 1e-12);
    }
}
