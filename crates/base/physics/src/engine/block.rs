//! One frictional contact point in a Gauss-Seidel sweep, in its own frame (two tangents, normal).

use paid_lanes::{Real, Vec3};

use super::cone::ConeLanes;
use super::solver::SOLVER;
use super::spatial::unit;

/// Inverse-mass constants of a contact point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Block<V> {
    inv_normal: V,
    /// Inverse of the tangential 2x2 block: xx, yy, xy.
    inv_tangent: [V; 3],
    /// Tangential velocity per normal impulse.
    tangent_per_normal: [V; 2],
    /// Mean tangential inverse mass over the normal one.
    ratio: V,
}

impl<V: Real> Block<V> {
    pub fn zero() -> Self {
        Self {
            inv_normal: V::zero(),
            inv_tangent: [V::zero(); 3],
            tangent_per_normal: [V::zero(); 2],
            ratio: V::zero(),
        }
    }

    /// From the point's symmetric inverse mass: t1t1, t2t2, nn, t1t2, t1n, t2n.
    #[inline(always)]
    pub fn new(k: [V; 6]) -> Self {
        let more = V::c(SOLVER.inverse_mass_factor);
        let (a, b, d) = (k[0] * more, k[1] * more, k[3]);
        let inv_det = d.neg_mul_add(d, a * b).recip();
        let inv_normal = (k[2] * more).recip();
        Self {
            inv_normal,
            ratio: V::c(0.5) * (a + b) * inv_normal,
            inv_tangent: [b * inv_det, a * inv_det, -(d * inv_det)],
            tangent_per_normal: [k[4], k[5]],
        }
    }

    /// Improves `impulse` (t1, t2, n) so that the relative velocity `v` reaches `target` along the normal and zero
    /// across, within no pull and the friction disc. `on` is 1 in lanes in contact, else 0.
    #[inline(always)]
    pub fn solve(
        &self,
        v: [V; 3],
        target: V,
        on: V,
        friction: Friction<V>,
        impulse: &mut [V; 3],
    ) -> Improved<V> {
        let old = *impulse;
        let normal = (target - v[2]).mul_add(self.inv_normal, old[2]).max(V::zero()) * on;
        let change = normal - old[2];
        let vx = self.tangent_per_normal[0].mul_add(change, v[0]);
        let vy = self.tangent_per_normal[1].mul_add(change, v[1]);
        let inv = &self.inv_tangent;
        let x = inv[0].neg_mul_add(vx, inv[2].neg_mul_add(vy, old[0]));
        let y = inv[1].neg_mul_add(vy, inv[2].neg_mul_add(vx, old[1]));
        let length2 = x.mul_add(x, y.mul_add(y, V::c(1e-12)));
        let inv_length = length2.rsqrt();
        let sticks = (length2 * inv_length).le(friction.stick * normal);
        let scale = V::select(sticks, V::one(), friction.slide * normal * inv_length);
        *impulse = [x * scale, y * scale, normal];
        Improved { change: [impulse[0] - old[0], impulse[1] - old[1], change], wanted: [x, y] }
    }

    /// [`Block::solve`] with each lane's kind of cone; the change alone.
    #[inline(always)]
    pub fn solve_cone(
        &self,
        v: [V; 3],
        target: V,
        on: V,
        friction: Friction<V>,
        cone: &ConeLanes<V>,
        impulse: &mut [V; 3],
    ) -> [V; 3] {
        let old = *impulse;
        let normal = (target - v[2]).mul_add(self.inv_normal, old[2]);
        let change = normal.max(V::zero()).mul_add(on, -old[2]);
        let vx = self.tangent_per_normal[0].mul_add(change, v[0]);
        let vy = self.tangent_per_normal[1].mul_add(change, v[1]);
        let inv = &self.inv_tangent;
        let x = inv[0].neg_mul_add(vx, inv[2].neg_mul_add(vy, old[0]));
        let y = inv[1].neg_mul_add(vy, inv[2].neg_mul_add(vx, old[1]));
        let [x, y, normal] = cone.limit([x, y, normal], self.ratio, friction);
        *impulse = [x * on, y * on, normal * on];
        [impulse[0] - old[0], impulse[1] - old[1], impulse[2] - old[2]]
    }
}

/// A contact sticks while its tangential impulse is within `stick` times the normal one, else it slides with `slide`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Friction<V> {
    pub stick: V,
    pub slide: V,
}

/// Result of [`Block::solve`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Improved<V> {
    /// Change of the impulse (t1, t2, n).
    pub change: [V; 3],
    /// Tangential impulse that sticking would take.
    pub wanted: [V; 2],
}

/// Two unit vectors that complete the unit vector `n`, which must not point along y.
#[inline(always)]
pub(crate) fn ground_tangents<V: Real>(n: Vec3<V>) -> [Vec3<V>; 2] {
    let inv = n.0[0].mul_add(n.0[0], n.0[2].mul_add(n.0[2], V::c(1e-12))).rsqrt();
    let t1 = Vec3::new(n.0[2] * inv, V::zero(), -n.0[0] * inv);
    [t1, n.cross(t1)]
}

/// Two unit vectors that complete any unit vector `n`.
#[inline(always)]
pub(crate) fn tangents<V: Real>(n: Vec3<V>) -> [Vec3<V>; 2] {
    let [x, y, z] = n.0;
    let along_z = V::c(0.7).lt(z.abs());
    let zero = V::zero();
    let t1 = Vec3::select(along_z, Vec3::new(z, zero, -x), Vec3::new(-y, x, zero));
    let t1 = unit(t1);
    [t1, n.cross(t1)]
}

/// The tangents along which MuJoCo lays the edges of a friction pyramid.
#[inline(always)]
pub(crate) fn pyramid_tangents<V: Real>(n: Vec3<V>) -> [Vec3<V>; 2] {
    let [x, y, z] = n.0;
    let across_y = y.abs().lt(V::c(0.5));
    // y or z less its part along n.
    let from_y = Vec3::new(-(y * x), y.neg_mul_add(y, V::one()), -(y * z));
    let from_z = Vec3::new(-(z * x), -(z * y), z.neg_mul_add(z, V::one()));
    let t1 = unit(Vec3::select(across_y, from_y, from_z));
    [t1, n.cross(t1)]
}

/// Normal speed that a contact must reach: just closing the gap when apart, correcting part of the overlap when
/// overlapping, bouncing when it hits fast enough.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Approach<V> {
    /// Reciprocal of the physics step `[1/s]`.
    pub inv_dt: V,
    /// Physics step `[s]`.
    pub dt: V,
    /// Speed below which nothing bounces `[m/s]`.
    pub bounce_threshold: V,
}

impl<V: Real> Approach<V> {
    /// `gap` negative when overlapping `[m]`; `slop` is the overlap that stays `[m]`; `speed` the normal velocity at the start of
    /// the step (negative when closing); `max_push` bounds the correction `[m/s]`.
    #[inline(always)]
    pub fn target(&self, gap: V, slop: f64, speed: V, restitution: V, max_push: f64) -> V {
        let zero = V::zero();
        let overlap = (-(gap + V::c(slop))).max(zero);
        let push = (overlap * (V::c(SOLVER.overlap_correction) * self.inv_dt)).min(V::c(max_push));
        let position = V::select(zero.lt(gap), -(gap * self.inv_dt), push);
        let hits = V::select(speed.mul_add(self.dt, gap).lt(zero), V::one(), zero);
        let bounce = V::select(speed.lt(-self.bounce_threshold), -(restitution * speed), zero);
        V::select(zero.lt(bounce * hits), position.max(bounce), position)
    }
}
