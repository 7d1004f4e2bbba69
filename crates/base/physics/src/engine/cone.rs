//! Limits of the ball's friction: disc or pyramid, and whether sliding lifts.

use paid_lanes::Real;

use super::block::Friction;

/// Kinds of friction cones, one value per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ConeLanes<V> {
    /// 1 a pyramid, 0 a disc.
    pub pyramid: V,
    /// 1: what slides lifts, 0: it does not (Coulomb).
    pub convex: V,
}

impl<V: Real> ConeLanes<V> {
    /// The impulse (t1, t2, n) within the cone, from the one without limits; `ratio` is the tangential inverse mass over the
    /// normal one.
    ///
    /// With `convex` the impulse is the nearest one in the cone by energy (M. Anitescu, "Optimization-based simulation of nonsmooth rigid
    /// multibody dynamics", 2006), as in MuJoCo: a residual slip `u` leaves the surfaces parting at `friction |u|`. The normal
    /// impulse `n` then obeys `n = n0 + ratio friction r(n)` with the residual tangential impulse `r`.
    #[inline(always)]
    pub fn limit(&self, [x, y, normal]: [V; 3], ratio: V, friction: Friction<V>) -> [V; 3] {
        let (zero, one, half) = (V::zero(), V::one(), V::c(0.5));
        let mu = friction.slide;
        let lift = self.convex * ratio * mu;
        let (ax, ay) = (x.abs(), y.abs());
        let (sum, larger) = (ax + ay, ax.max(ay));
        let length2 = x.mul_add(x, y.mul_add(y, V::c(1e-12)));
        let inv_length = length2.rsqrt();
        let length = length2 * inv_length;
        let pyramid = half.lt(self.pyramid);
        // Disc: r = length - mu n. Pyramid: the larger of (sum - mu n) / 2 and larger - mu n.
        let single = V::select(pyramid, larger, length);
        let by_single = lift.mul_add(single, normal) * lift.mul_add(mu, one).recip();
        let halved = half * lift;
        let by_sum = halved.mul_add(sum, normal) * halved.mul_add(mu, one).recip();
        let raised = normal.max(by_single).max(V::select(pyramid, by_sum, zero));
        let normal = V::select(half.lt(self.convex), raised, normal).max(zero);
        let most = mu * normal;
        // Nearest point of the pyramid: both parts shrink by the same until one is zero.
        let shrink = (half * (sum - most)).max(zero);
        let (px, py) = ((ax - shrink).max(zero).min(most), (ay - shrink).max(zero).min(most));
        let sign = |v: V, size: V| V::select(v.lt(zero), -size, size);
        let stick = friction.stick * normal;
        let scale = V::select(length.le(stick), one, most * inv_length);
        let sticks = sum.le(stick);
        let px = V::select(sticks, x, sign(x, px));
        let py = V::select(sticks, y, sign(y, py));
        [V::select(pyramid, px, x * scale), V::select(pyramid, py, y * scale), normal]
    }

    /// The part of the normal impulse that friction along the tangents leaves for friction of spin.
    #[inline(always)]
    pub fn left(&self, [x, y, normal]: [V; 3], mu: V) -> V {
        let zero = V::zero();
        let inv_mu = mu.max(V::c(1e-3)).recip();
        let (tx, ty) = (x * inv_mu, y * inv_mu);
        let of_pyramid = (normal - tx.abs() - ty.abs()).max(zero);
        let of_disc = tx.neg_mul_add(tx, ty.neg_mul_add(ty, normal * normal)).max(zero).sqrt();
        V::select(V::c(0.5).lt(self.pyramid), of_pyramid, of_disc)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(found: [f64; 3], want: [f64; 3]) {
        assert!(found.iter().zip(want).all(|(a, b)| (a - b).abs() < 1e-5), "{found:?}, expected {want:?}");
    }

    fn limit(pyramid: f64, convex: f64, f: [f64; 3]) -> [f64; 3] {
        ConeLanes { pyramid, convex }.limit(f, 2.5, Friction { stick: 0.5, slide: 0.5 })
    }

    #[test]
    fn what_is_inside_stays() {
        for (pyramid, convex) in [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)] {
            near(limit(pyramid, convex, [0.3, -0.1, 1.0]), [0.3, -0.1, 1.0]);
        }
    }

    #[test]
    fn the_disc_shortens_and_the_pyramid_moves_to_its_nearest_point() {
        near(limit(0.0, 0.0, [3.0, -4.0, 2.0]), [0.6, -0.8, 2.0]);
        // |x| + |y| = 1: 0.9 and 0.5 shrink by 0.2 each.
        near(limit(1.0, 0.0, [0.9, -0.5, 2.0]), [0.7, -0.3, 2.0]);
        near(limit(1.0, 0.0, [3.0, -0.5, 2.0]), [1.0, 0.0, 2.0]);
    }

    #[test]
    fn convex_sliding_lifts() {
        // Disc: n = (2 + 1.25 * 5) / (1 + 1.25 * 0.5).
        let n = 8.25 / 1.625;
        near(limit(0.0, 1.0, [3.0, -4.0, 2.0]), [0.3 * n, -0.4 * n, n]);
        // A slip that is fast enough presses even where the surfaces part.
        assert!(limit(0.0, 1.0, [3.0, -4.0, -1.0])[2] > 0.0);
        assert_eq!(limit(0.0, 0.0, [3.0, -4.0, -1.0])[2], 0.0);
    }

    #[test]
    fn friction_along_the_surface_leaves_the_rest_for_spin() {
        let left = |pyramid| ConeLanes { pyramid, convex: 0.0 }.left([0.3, -0.4, 2.0], 0.5);
        assert!((left(1.0) - 0.6).abs() < 1e-12);
        assert!((left(0.0) - 3.0_f64.sqrt()).abs() < 1e-12);
    }
}
