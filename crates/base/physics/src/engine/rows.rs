//! Contact rows of any link, in factored coordinates.
//!
//! With `M = L D L^T` (the articulated-body factorization), an impulse `J^T x` is kept as `s = L^-1 J^T x`, one number per
//! joint on the path to the base and six at the base. Then the velocity of row `J` is `free + y . D^-1 s` with
//! `y = L^-1 J^T`, so any two rows are coupled exactly at the cost of one path each.

use paid_lanes::{Mask, Real, Vec3};

use super::group::Work;
use super::layout::ModelLayout;
use super::spatial::{Force, Motion, dot6};

/// Half-solved rows of a point on one path.
#[derive(Clone, Debug)]
pub(crate) struct Rows<V, const N: usize> {
    /// Joint (base to tip) by row.
    pub joints: Vec<[V; N]>,
    /// What arrives at the base: half-solved once all paths of the contact are in, row of the base by row.
    pub base: [[V; N]; 6],
}

/// 1 in lanes whose `body` is `index`, else 0.
#[inline(always)]
pub(crate) fn is_body<V: Real>(body: V, index: usize) -> V {
    V::select((body - V::c(index as f64)).abs().lt(V::c(0.5)), V::one(), V::zero())
}

/// True if all are zero in every lane, so that adding multiples of them changes nothing. Contacts are prepared before they touch, and
/// most of those never push.
#[inline(always)]
pub(crate) fn is_zero<V: Real>(x: &[V; 3]) -> bool {
    !(x[0].abs() + x[1].abs() + x[2].abs()).le(V::zero()).not().any()
}

impl<V: Real> Rows<V, 3> {
    /// The joints' share of [`Rows::couplings`].
    #[inline(always)]
    pub fn joint_couplings(&self, w: &Work<V>, path: &[usize]) -> [V; 6] {
        let mut sums = [V::zero(); 6];
        for i in 0..path.len() {
            add_couplings(&mut sums, &self.joints[i], w.joints[path[i]].inv);
        }
        sums
    }

    /// `J M^-1 J^T` of a contact with one path, entries as [`Block::new`](super::block::Block::new) takes them.
    #[inline(always)]
    pub fn couplings(&self, w: &Work<V>, path: &[usize]) -> [V; 6] {
        let mut base = [V::zero(); 6];
        for i in 0..6 {
            add_couplings(&mut base, &self.base[i], w.factor.inv[i]);
        }
        let mut sums = self.joint_couplings(w, path);
        for k in 0..6 {
            sums[k] += base[k];
        }
        sums
    }
}

/// Adds the products of `y` with `inv` and itself: t1t1, t2t2, nn, t1t2, t1n, t2n.
#[inline(always)]
fn add_couplings<V: Real>(sums: &mut [V; 6], y: &[V; 3], inv: V) {
    let scaled = [y[0] * inv, y[1] * inv];
    sums[0] = scaled[0].mul_add(y[0], sums[0]);
    sums[1] = scaled[1].mul_add(y[1], sums[1]);
    sums[2] = (y[2] * inv).mul_add(y[2], sums[2]);
    sums[3] = scaled[0].mul_add(y[1], sums[3]);
    sums[4] = scaled[0].mul_add(y[2], sums[4]);
    sums[5] = scaled[1].mul_add(y[2], sums[5]);
}

impl<V: Real, const N: usize> Rows<V, N> {
    pub fn new(joints: usize) -> Self {
        Self { joints: vec![[V::zero(); N]; joints], base: [[V::zero(); N]; 6] }
    }

    /// Carries unit impulses `directions` at `point` on the lanes' `body` along `path` to the base, without the base's own
    /// half-solve.
    #[inline(always)]
    pub fn carry_to_base(
        &mut self,
        w: &Work<V>,
        path: &[usize],
        body: V,
        point: Vec3<V>,
        directions: &[Vec3<V>; N],
    ) {
        let mut unit = [[V::zero(); N]; 6];
        for c in 0..N {
            let wrench = Force { ang: point.cross(directions[c]), lin: directions[c] }.array();
            for r in 0..6 {
                unit[r][c] = wrench[r];
            }
        }
        let mut p = [[V::zero(); N]; 6];
        for i in (0..path.len()).rev() {
            let joint = &w.joints[path[i]];
            let here = is_body(body, path[i] + 1);
            let axis = joint.axis.array();
            for c in 0..N {
                for r in 0..6 {
                    p[r][c] = unit[r][c].mul_add(here, p[r][c]);
                }
                let column = [p[0][c], p[1][c], p[2][c], p[3][c], p[4][c], p[5][c]];
                let y = dot6(&axis, &column);
                self.joints[i][c] = y;
                for r in 0..6 {
                    p[r][c] = joint.gain[r].neg_mul_add(y, p[r][c]);
                }
            }
        }
        let here = is_body(body, 0);
        for r in 0..6 {
            for c in 0..N {
                self.base[r][c] = unit[r][c].mul_add(here, p[r][c]);
            }
        }
    }

    /// The base's half-solve of what [`Rows::carry_to_base`] brought there.
    #[inline(always)]
    pub fn solve_base(&mut self, w: &Work<V>) {
        for c in 0..N {
            let b = &self.base;
            let mut column = [b[0][c], b[1][c], b[2][c], b[3][c], b[4][c], b[5][c]];
            w.factor.half_solve(&mut column);
            for r in 0..6 {
                self.base[r][c] = column[r];
            }
        }
    }

    /// Velocity that the joints' free motion adds to the rows over the step.
    #[inline(always)]
    pub fn free_joints(&self, w: &Work<V>, path: &[usize], dt: V, out: &mut [V; N]) {
        for i in 0..path.len() {
            let joint = &w.joints[path[i]];
            let x = joint.torque * joint.inv * dt;
            for c in 0..N {
                out[c] = self.joints[i][c].mul_add(x, out[c]);
            }
        }
    }

    /// Velocity that the base's free motion adds to the rows over the step.
    #[inline(always)]
    pub fn free_base(&self, w: &Work<V>, out: &mut [V; N]) {
        for i in 0..6 {
            let x = w.base_free[i] * w.factor.inv[i];
            for c in 0..N {
                out[c] = self.base[i][c].mul_add(x, out[c]);
            }
        }
    }

    /// Velocity that all contact impulses so far add through the joints.
    #[inline(always)]
    pub fn pushed_joints(&self, w: &Work<V>, path: &[usize], out: &mut [V; N]) {
        for i in 0..path.len() {
            let joint = &w.joints[path[i]];
            let x = (joint.impulse + joint.sole_impulse) * joint.inv;
            for c in 0..N {
                out[c] = self.joints[i][c].mul_add(x, out[c]);
            }
        }
    }

    /// Velocity that all contact impulses so far add through the base.
    #[inline(always)]
    pub fn pushed_base(&self, w: &Work<V>, out: &mut [V; N]) {
        for i in 0..6 {
            let x = (w.base_impulse[i] + w.base_sole_impulse[i]) * w.factor.inv[i];
            for c in 0..N {
                out[c] = self.base[i][c].mul_add(x, out[c]);
            }
        }
    }

    /// Adds an impulse on the rows to the path's joints.
    #[inline(always)]
    pub fn push_joints(&self, w: &mut Work<V>, path: &[usize], change: &[V; N]) {
        for i in 0..path.len() {
            let joint = &mut w.joints[path[i]];
            for c in 0..N {
                let x = self.joints[i][c] * change[c];
                joint.impulse += x;
                joint.pending += x;
            }
        }
    }

    /// Adds an impulse on the rows to the base.
    #[inline(always)]
    pub fn push_base(&self, w: &mut Work<V>, change: &[V; N]) {
        for i in 0..6 {
            for c in 0..N {
                let x = self.base[i][c] * change[c];
                w.base_impulse[i] += x;
                w.base_pending[i] += x;
            }
        }
    }
}

/// Writes the soles' impulses so far into factored coordinates, for the rows to see.
#[inline(always)]
pub(crate) fn spread_soles<V: Real>(layout: &ModelLayout<V::Scalar>, w: &mut Work<V>) {
    w.base_sole_impulse = [V::zero(); 6];
    for f in 0..2 {
        let first = layout.chains[layout.legs[f]].first;
        let foot = &w.feet[f];
        let total = foot.impulse.array();
        for i in 0..foot.joints.len() {
            w.joints[first + i].sole_impulse = dot6(&foot.joints[i], &total);
        }
        for r in 0..6 {
            w.base_sole_impulse[r] += dot6(&foot.base[r], &total);
        }
    }
}

/// Passes the rows' impulses since the last call on to the feet's velocities.
#[inline(always)]
pub(crate) fn push_feet<V: Real>(layout: &ModelLayout<V::Scalar>, w: &mut Work<V>) {
    for f in 0..2 {
        let first = layout.chains[layout.legs[f]].first;
        let foot = &mut w.feet[f];
        let mut v = foot.vel.array();
        for i in 0..foot.joints.len() {
            let x = w.joints[first + i].pending * w.joints[first + i].inv;
            for c in 0..6 {
                v[c] = foot.joints[i][c].mul_add(x, v[c]);
            }
        }
        for r in 0..6 {
            let x = w.base_pending[r] * w.factor.inv[r];
            for c in 0..6 {
                v[c] = foot.base[r][c].mul_add(x, v[c]);
            }
        }
        foot.vel = Motion::from_array(v);
    }
    for joint in &mut w.joints {
        joint.pending = V::zero();
    }
    w.base_pending = [V::zero(); 6];
}
