//! Six-dimensional motions, forces and inertias in world axes about one common origin (the base's origin).
//!
//! Using one frame for the whole tree, nothing has to be transformed between links (Featherstone, "Rigid Body
//! Dynamics Algorithms", 2008, for the algebra).

use paid_lanes::{Mat3, Real, Vec3};

/// Angular and linear velocity (or acceleration) of the body-fixed point at the origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Motion<V> {
    pub ang: Vec3<V>,
    pub lin: Vec3<V>,
}

/// Moment about the origin and force (or their impulses).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Force<V> {
    pub ang: Vec3<V>,
    pub lin: Vec3<V>,
}

macro_rules! six {
    ($t:ident) => {
        impl<V: Real> $t<V> {
            #[inline(always)]
            pub fn zero() -> Self {
                Self { ang: Vec3::zero(), lin: Vec3::zero() }
            }
            #[inline(always)]
            pub fn array(&self) -> [V; 6] {
                let (a, l) = (self.ang.0, self.lin.0);
                [a[0], a[1], a[2], l[0], l[1], l[2]]
            }
            #[inline(always)]
            pub fn from_array(x: [V; 6]) -> Self {
                Self { ang: Vec3([x[0], x[1], x[2]]), lin: Vec3([x[3], x[4], x[5]]) }
            }
            /// `self + other * k`.
            #[inline(always)]
            pub fn plus(self, other: Self, k: V) -> Self {
                Self { ang: other.ang.scale_add(k, self.ang), lin: other.lin.scale_add(k, self.lin) }
            }
        }
    };
}
six!(Motion);
six!(Force);

impl<V: Real> Motion<V> {
    /// Power of a force under this motion.
    #[inline(always)]
    pub fn dot(self, f: Force<V>) -> V {
        self.ang.dot(f.ang) + self.lin.dot(f.lin)
    }
    /// Velocity of the body-fixed point at `p`.
    #[inline(always)]
    pub fn at(self, p: Vec3<V>) -> Vec3<V> {
        self.ang.cross_add(p, self.lin)
    }
}

/// Symmetric 3x3: xx, yy, zz, xy, xz, yz.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sym3<V>(pub [V; 6]);

impl<V: Real> Sym3<V> {
    #[inline(always)]
    pub fn mul(&self, v: Vec3<V>) -> Vec3<V> {
        let a = &self.0;
        Vec3([
            Vec3([a[0], a[3], a[4]]).dot(v),
            Vec3([a[3], a[1], a[5]]).dot(v),
            Vec3([a[4], a[5], a[2]]).dot(v),
        ])
    }
    #[inline(always)]
    pub fn at(&self, r: usize, c: usize) -> V {
        const INDEX: [[usize; 3]; 3] = [[0, 3, 4], [3, 1, 5], [4, 5, 2]];
        self.0[INDEX[r][c]]
    }
    /// `self - x y^T` where the product is known to be symmetric.
    #[inline(always)]
    pub fn minus_outer(&mut self, x: Vec3<V>, y: Vec3<V>) {
        let (a, x, y) = (&mut self.0, x.0, y.0);
        a[0] = x[0].neg_mul_add(y[0], a[0]);
        a[1] = x[1].neg_mul_add(y[1], a[1]);
        a[2] = x[2].neg_mul_add(y[2], a[2]);
        a[3] = x[0].neg_mul_add(y[1], a[3]);
        a[4] = x[0].neg_mul_add(y[2], a[4]);
        a[5] = x[1].neg_mul_add(y[2], a[5]);
    }
}

/// Inertia of one rigid body about the origin, and the force that its velocity and gravity need.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rigid<V> {
    pub mass: V,
    /// Mass times center of mass.
    pub first: Vec3<V>,
    /// Rotational inertia about the origin.
    pub second: Sym3<V>,
    /// `I a + v x* I v`, with `a` the velocity-product acceleration less gravity.
    pub bias: Force<V>,
}

impl<V: Real> Rigid<V> {
    /// `com` in the body frame; `inertia` about the center of mass in body axes; `pos`, `rot` place the body frame.
    #[inline(always)]
    pub fn new(mass: V, com: Vec3<V>, inertia: Sym3<V>, kin: &Kin<V>) -> Self {
        let c = kin.rot.mul_vec(com) + kin.pos;
        let h = c.scale(mass);
        let rows = [Vec3(kin.rot.0[0]), Vec3(kin.rot.0[1]), Vec3(kin.rot.0[2])];
        let turned = [inertia.mul(rows[0]), inertia.mul(rows[1]), inertia.mul(rows[2])];
        let (c0, h0) = (c.0, h.0);
        let (xx, yy, zz) = (c0[0] * h0[0], c0[1] * h0[1], c0[2] * h0[2]);
        let second = Sym3([
            turned[0].dot(rows[0]) + (yy + zz),
            turned[1].dot(rows[1]) + (xx + zz),
            turned[2].dot(rows[2]) + (xx + yy),
            c0[0].neg_mul_add(h0[1], turned[0].dot(rows[1])),
            c0[0].neg_mul_add(h0[2], turned[0].dot(rows[2])),
            c0[1].neg_mul_add(h0[2], turned[1].dot(rows[2])),
        ]);
        let (v, a) = (kin.vel, kin.acc);
        let spin = h.cross_add(v.lin, second.mul(v.ang));
        let momentum = v.ang.cross_add(h, v.lin.scale(mass));
        let moment = h.cross_add(a.lin, second.mul(a.ang));
        let force = a.ang.cross_add(h, a.lin.scale(mass));
        let moment = v.lin.cross_add(momentum, v.ang.cross_add(spin, moment));
        let force = v.ang.cross_add(momentum, force);
        Self { mass, first: h, second, bias: Force { ang: moment, lin: force } }
    }

    /// Mass and inertia, and with them the bias, multiplied by `k`.
    #[inline(always)]
    pub fn scale(&mut self, k: V) {
        self.mass *= k;
        self.first = self.first.scale(k);
        for x in &mut self.second.0 {
            *x *= k;
        }
        self.bias = Force { ang: self.bias.ang.scale(k), lin: self.bias.lin.scale(k) };
    }
}

/// Pose and motion of a link; positions are relative to the base's origin.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Kin<V> {
    pub rot: Mat3<V>,
    pub pos: Vec3<V>,
    pub vel: Motion<V>,
    /// Velocity-product acceleration less gravity, accumulated from the base.
    pub acc: Motion<V>,
}

impl<V: Real> Kin<V> {
    #[inline(always)]
    pub fn zero() -> Self {
        Self { rot: Mat3::identity(), pos: Vec3::zero(), vel: Motion::zero(), acc: Motion::zero() }
    }
    /// A body-fixed point, relative to the base's origin.
    #[inline(always)]
    pub fn place(&self, point: Vec3<V>) -> Vec3<V> {
        self.rot.mul_vec(point) + self.pos
    }
}

/// Length of a vector to the precision of [`Real::rsqrt`], which costs less than a square root.
#[inline(always)]
pub(crate) fn length<V: Real>(v: Vec3<V>) -> V {
    let squared = v.norm2() + V::c(1e-12);
    squared * squared.rsqrt()
}

/// The unit vector along `v`; zero stays zero.
#[inline(always)]
pub(crate) fn unit<V: Real>(v: Vec3<V>) -> Vec3<V> {
    v.scale((v.norm2() + V::c(1e-12)).rsqrt())
}

/// A constant vector in every lane.
#[inline(always)]
pub(crate) fn splat3<V: Real>(x: &[V::Scalar; 3]) -> Vec3<V> {
    Vec3([V::splat(x[0]), V::splat(x[1]), V::splat(x[2])])
}

/// A constant symmetric matrix in every lane.
#[inline(always)]
pub(crate) fn splat_sym<V: Real>(x: &[V::Scalar; 6]) -> Sym3<V> {
    let mut out = [V::zero(); 6];
    for i in 0..6 {
        out[i] = V::splat(x[i]);
    }
    Sym3(out)
}

/// Product of two vectors of six.
#[inline(always)]
pub(crate) fn dot6<V: Real>(a: &[V; 6], b: &[V; 6]) -> V {
    let x = a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]));
    let y = a[5].mul_add(b[5], a[4].mul_add(b[4], a[3] * b[3]));
    x + y
}
