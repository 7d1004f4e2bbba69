//! Articulated-body inertias and the factorization of the base's.

use paid_lanes::{Mat3, Real, Vec3};

use super::spatial::{Force, Motion, Rigid, Sym3};

/// Articulated inertia `[[a, b], [b^T, m]]` (angular first) and its bias force.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Articulated<V> {
    pub a: Sym3<V>,
    pub b: Mat3<V>,
    pub m: Sym3<V>,
    pub bias: Force<V>,
}

impl<V: Real> Articulated<V> {
    #[inline(always)]
    pub fn zero() -> Self {
        let z = V::zero();
        Self { a: Sym3([z; 6]), b: Mat3([[z; 3]; 3]), m: Sym3([z; 6]), bias: Force::zero() }
    }

    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        for i in 0..6 {
            self.a.0[i] += other.a.0[i];
            self.m.0[i] += other.m.0[i];
        }
        for r in 0..3 {
            for c in 0..3 {
                self.b.0[r][c] += other.b.0[r][c];
            }
        }
        self.bias.ang += other.bias.ang;
        self.bias.lin += other.bias.lin;
    }

    #[inline(always)]
    pub fn add_rigid(&mut self, r: &Rigid<V>) {
        for i in 0..6 {
            self.a.0[i] += r.second.0[i];
        }
        for i in 0..3 {
            self.m.0[i] += r.mass;
        }
        let [x, y, z] = r.first.0;
        let b = &mut self.b.0;
        b[0][1] -= z;
        b[0][2] += y;
        b[1][0] += z;
        b[1][2] -= x;
        b[2][0] -= y;
        b[2][1] += x;
        self.bias.ang += r.bias.ang;
        self.bias.lin += r.bias.lin;
    }

    /// Adds a point at `p` that resists motion along the unit vectors `n` with mass `along` and across with `across`
    /// (an implicit contact), and the force `f` that acts on it.
    #[inline(always)]
    pub fn add_point(&mut self, p: Vec3<V>, n: Vec3<V>, along: V, across: V, f: Vec3<V>) {
        // K = across 1 + (along - across) n n^T; with w = p x n the inertia is a = across (p.p 1 - p p^T) + d w w^T,
        // b = [p]x K, m = K.
        let d = along - across;
        let w = p.cross(n);
        let [x, y, z] = p.0;
        let (wd, nd) = (w.scale(d), n.scale(d));
        let (xx, yy, zz) = (x * x, y * y, z * z);
        let (w, n) = (w.0, n.0);
        let a = &mut self.a.0;
        a[0] += across.mul_add(yy + zz, wd.0[0] * w[0]);
        a[1] += across.mul_add(xx + zz, wd.0[1] * w[1]);
        a[2] += across.mul_add(xx + yy, wd.0[2] * w[2]);
        a[3] += wd.0[0] * w[1] - across * x * y;
        a[4] += wd.0[0] * w[2] - across * x * z;
        a[5] += wd.0[1] * w[2] - across * y * z;
        let cross = [[V::zero(), -z, y], [z, V::zero(), -x], [-y, x, V::zero()]];
        for r in 0..3 {
            for c in 0..3 {
                self.b.0[r][c] += across.mul_add(cross[r][c], wd.0[r] * n[c]);
            }
        }
        let m = &mut self.m.0;
        for i in 0..3 {
            m[i] += across.mul_add(V::one(), nd.0[i] * n[i]);
        }
        m[3] += nd.0[0] * n[1];
        m[4] += nd.0[0] * n[2];
        m[5] += nd.0[1] * n[2];
        self.bias.ang = self.bias.ang - p.cross(f);
        self.bias.lin = self.bias.lin - f;
    }

    /// `I m`, the force that the acceleration `m` needs.
    #[inline(always)]
    pub fn mul(&self, m: Motion<V>) -> Force<V> {
        let ang = self.a.mul(m.ang) + self.b.mul_vec(m.lin);
        let lin = self.m.mul(m.lin) + self.b.tr_mul_vec(m.ang);
        Force { ang, lin }
    }

    /// Element of the 6x6 matrix.
    #[inline(always)]
    pub fn at(&self, r: usize, c: usize) -> V {
        if r < 3 && c < 3 {
            self.a.at(r, c)
        } else if r >= 3 && c >= 3 {
            self.m.at(r - 3, c - 3)
        } else if r < 3 {
            self.b.0[r][c - 3]
        } else {
            self.b.0[c][r - 3]
        }
    }
}

/// `L D L^T` of the base's articulated inertia.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BaseFactor<V> {
    /// Strictly lower triangle, row by row.
    pub lower: [V; 15],
    /// Reciprocals of D.
    pub inv: [V; 6],
}

impl<V: Real> BaseFactor<V> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { lower: [V::zero(); 15], inv: [V::zero(); 6] }
    }

    #[inline(always)]
    pub fn new(art: &Articulated<V>) -> Self {
        let mut l = [[V::zero(); 6]; 6];
        let mut d = [V::zero(); 6];
        let mut out = Self::zero();
        for c in 0..6 {
            d[c] = art.at(c, c);
            for k in 0..c {
                d[c] = (l[c][k] * l[c][k]).neg_mul_add(d[k], d[c]);
            }
            out.inv[c] = d[c].recip();
            for r in c + 1..6 {
                let mut x = art.at(r, c);
                for k in 0..c {
                    x = (l[r][k] * d[k]).neg_mul_add(l[c][k], x);
                }
                l[r][c] = x * out.inv[c];
            }
        }
        let mut n = 0;
        for r in 1..6 {
            for c in 0..r {
                out.lower[n] = l[r][c];
                n += 1;
            }
        }
        out
    }

    /// `L^-1 x`.
    #[inline(always)]
    pub fn half_solve(&self, x: &mut [V; 6]) {
        let mut n = 0;
        for r in 1..6 {
            for c in 0..r {
                x[r] = self.lower[n].neg_mul_add(x[c], x[r]);
                n += 1;
            }
        }
    }

    /// `L^-T D^-1 x`.
    #[inline(always)]
    pub fn finish(&self, x: &mut [V; 6]) {
        for i in 0..6 {
            x[i] *= self.inv[i];
        }
        for r in (0..6).rev() {
            for c in 0..r {
                x[c] = self.lower[r * (r - 1) / 2 + c].neg_mul_add(x[r], x[c]);
            }
        }
    }
}
