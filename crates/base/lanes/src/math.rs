//! Three-dimensional vectors, rotation matrices and quaternions over [`Real`].
//!
//! Rotations act on column vectors. Quaternions are ordered w, x, y, z.

use crate::Real;

/// A vector of three components x, y, z.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Vec3<V>(pub [V; 3]);

/// A 3x3 matrix, row-major.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Mat3<V>(pub [[V; 3]; 3]);

/// A quaternion w, x, y, z.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Quat<V>(pub [V; 4]);

impl<V: Real> Vec3<V> {
    /// From components.
    #[inline(always)]
    pub fn new(x: V, y: V, z: V) -> Self {
        Self([x, y, z])
    }
    /// The same constant vector in every lane.
    #[inline(always)]
    pub fn c(v: [f64; 3]) -> Self {
        Self([V::c(v[0]), V::c(v[1]), V::c(v[2])])
    }
    /// The zero vector.
    #[inline(always)]
    pub fn zero() -> Self {
        Self([V::zero(); 3])
    }
    /// Component x.
    #[inline(always)]
    pub fn x(&self) -> V {
        self.0[0]
    }
    /// Component y.
    #[inline(always)]
    pub fn y(&self) -> V {
        self.0[1]
    }
    /// Component z.
    #[inline(always)]
    pub fn z(&self) -> V {
        self.0[2]
    }
    /// `self * k`.
    #[inline(always)]
    pub fn scale(self, k: V) -> Self {
        Self([self.0[0] * k, self.0[1] * k, self.0[2] * k])
    }
    /// `self * k + other`.
    #[inline(always)]
    pub fn scale_add(self, k: V, other: Self) -> Self {
        Self([
            self.0[0].mul_add(k, other.0[0]),
            self.0[1].mul_add(k, other.0[1]),
            self.0[2].mul_add(k, other.0[2]),
        ])
    }
    /// Scalar product.
    #[inline(always)]
    pub fn dot(self, b: Self) -> V {
        self.0[2].mul_add(b.0[2], self.0[1].mul_add(b.0[1], self.0[0] * b.0[0]))
    }
    /// Vector product.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        let a = self.0;
        let b = b.0;
        Self([
            b[1].neg_mul_add(a[2], a[1] * b[2]),
            b[2].neg_mul_add(a[0], a[2] * b[0]),
            b[0].neg_mul_add(a[1], a[0] * b[1]),
        ])
    }
    /// `self x b + c`.
    #[inline(always)]
    pub fn cross_add(self, b: Self, c: Self) -> Self {
        let a = self.0;
        let b = b.0;
        Self([
            b[1].neg_mul_add(a[2], a[1].mul_add(b[2], c.0[0])),
            b[2].neg_mul_add(a[0], a[2].mul_add(b[0], c.0[1])),
            b[0].neg_mul_add(a[1], a[0].mul_add(b[1], c.0[2])),
        ])
    }
    /// Squared Euclidean norm.
    #[inline(always)]
    pub fn norm2(self) -> V {
        self.dot(self)
    }
    /// Euclidean norm.
    #[inline(always)]
    pub fn norm(self) -> V {
        self.norm2().sqrt()
    }
    /// `if_true` where the mask is set.
    #[inline(always)]
    pub fn select(mask: V::Mask, if_true: Self, if_false: Self) -> Self {
        Self([
            V::select(mask, if_true.0[0], if_false.0[0]),
            V::select(mask, if_true.0[1], if_false.0[1]),
            V::select(mask, if_true.0[2], if_false.0[2]),
        ])
    }
    /// The vector of one lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> [f64; 3] {
        [self.0[0].lane(i), self.0[1].lane(i), self.0[2].lane(i)]
    }
    /// Sets one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, i: usize, v: [f64; 3]) {
        for k in 0..3 {
            self.0[k].set_lane(i, v[k]);
        }
    }
}

macro_rules! vec_op {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<V: Real> core::ops::$trait for Vec3<V> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, b: Self) -> Self {
                Self([self.0[0] $op b.0[0], self.0[1] $op b.0[1], self.0[2] $op b.0[2]])
            }
        }
    };
}
vec_op!(Add, add, +);
vec_op!(Sub, sub, -);

impl<V: Real> core::ops::AddAssign for Vec3<V> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<V: Real> core::ops::Neg for Vec3<V> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self([-self.0[0], -self.0[1], -self.0[2]])
    }
}

impl<V: Real> Mat3<V> {
    /// The identity.
    #[inline(always)]
    pub fn identity() -> Self {
        let (o, z) = (V::one(), V::zero());
        Self([[o, z, z], [z, o, z], [z, z, o]])
    }
    /// The same constant matrix in every lane.
    #[inline(always)]
    pub fn c(m: [[f64; 3]; 3]) -> Self {
        Self([Vec3::c(m[0]).0, Vec3::c(m[1]).0, Vec3::c(m[2]).0])
    }
    /// `self v`.
    #[inline(always)]
    pub fn mul_vec(&self, v: Vec3<V>) -> Vec3<V> {
        Vec3([Vec3(self.0[0]).dot(v), Vec3(self.0[1]).dot(v), Vec3(self.0[2]).dot(v)])
    }
    /// `self^T v`: for a rotation, the inverse applied to `v`.
    #[inline(always)]
    pub fn tr_mul_vec(&self, v: Vec3<V>) -> Vec3<V> {
        let [a, b, c] = self.0;
        Vec3(c).scale_add(v.0[2], Vec3(b).scale_add(v.0[1], Vec3(a).scale(v.0[0])))
    }
    /// `self other`.
    #[inline(always)]
    pub fn mul_mat(&self, other: &Self) -> Self {
        let mut out = self.0;
        for r in 0..3 {
            out[r] = other.tr_mul_vec(Vec3(self.0[r])).0;
        }
        Self(out)
    }
    /// `self^T other`: for rotations, `other` seen from `self`.
    #[inline(always)]
    pub fn tr_mul_mat(&self, other: &Self) -> Self {
        self.transpose().mul_mat(other)
    }
    /// The transpose.
    #[inline(always)]
    pub fn transpose(&self) -> Self {
        let m = self.0;
        Self([[m[0][0], m[1][0], m[2][0]], [m[0][1], m[1][1], m[2][1]], [m[0][2], m[1][2], m[2][2]]])
    }
    /// Column `k`: for a rotation, axis `k` of the rotated frame.
    #[inline(always)]
    pub fn col(&self, k: usize) -> Vec3<V> {
        Vec3([self.0[0][k], self.0[1][k], self.0[2][k]])
    }
    /// Heading of the x axis about z `[rad]`.
    #[inline(always)]
    pub fn yaw(&self) -> V {
        self.0[1][0].atan2(self.0[0][0])
    }
    /// The rotation about z that shares this rotation's heading, without trigonometry.
    #[inline(always)]
    pub fn yaw_only(&self) -> Self {
        let (c, s, z) = (self.0[0][0], self.0[1][0], V::zero());
        let inv = c.mul_add(c, s.mul_add(s, V::c(1e-20))).rsqrt();
        let (c, s) = (c * inv, s * inv);
        Self([[c, -s, z], [s, c, z], [z, z, V::one()]])
    }
    /// Rotation angle in [0, pi] `[rad]` of a rotation matrix.
    #[inline(always)]
    pub fn angle(&self) -> V {
        let m = &self.0;
        let axis = Vec3([m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]]);
        let two_sin = axis.norm();
        let two_cos = m[0][0] + m[1][1] + m[2][2] - V::one();
        two_sin.atan2(two_cos)
    }
}

impl Mat3<f64> {
    /// The unit quaternion of a rotation matrix; its largest component is positive.
    pub fn to_quat(&self) -> Quat<f64> {
        let m = &self.0;
        // The largest of the four is found from the diagonal, so that nothing is divided by a small number.
        let squares = [
            1.0 + m[0][0] + m[1][1] + m[2][2],
            1.0 + m[0][0] - m[1][1] - m[2][2],
            1.0 - m[0][0] + m[1][1] - m[2][2],
            1.0 - m[0][0] - m[1][1] + m[2][2],
        ];
        let largest = (0..4).fold(0, |best, k| if squares[k] > squares[best] { k } else { best });
        let (dx, dy, dz) = (m[2][1] - m[1][2], m[0][2] - m[2][0], m[1][0] - m[0][1]);
        let (xy, xz, yz) = (m[1][0] + m[0][1], m[0][2] + m[2][0], m[2][1] + m[1][2]);
        let s = squares[largest];
        let q = match largest {
            0 => [s, dx, dy, dz],
            1 => [dx, s, xy, xz],
            2 => [dy, xy, s, yz],
            _ => [dz, xz, yz, s],
        };
        let norm = q.iter().map(|x| x * x).sum::<f64>().sqrt();
        Quat(q.map(|x| x / norm))
    }
}

impl<V: Real> Quat<V> {
    /// No rotation.
    #[inline(always)]
    pub fn identity() -> Self {
        Self([V::one(), V::zero(), V::zero(), V::zero()])
    }
    /// The same constant quaternion (w, x, y, z) in every lane.
    #[inline(always)]
    pub fn c(q: [f64; 4]) -> Self {
        Self([V::c(q[0]), V::c(q[1]), V::c(q[2]), V::c(q[3])])
    }
    /// Rotation by `angle` `[rad]` about the unit vector `axis`.
    #[inline(always)]
    pub fn from_axis_angle(axis: Vec3<V>, angle: V) -> Self {
        let (s, c) = (angle * V::c(0.5)).sin_cos();
        Self([c, axis.0[0] * s, axis.0[1] * s, axis.0[2] * s])
    }
    /// Rotation from extrinsic roll (x), then pitch (y), then yaw (z) `[rad]`.
    #[inline(always)]
    pub fn from_roll_pitch_yaw(roll: V, pitch: V, yaw: V) -> Self {
        let z = Self::from_axis_angle(Vec3::c([0.0, 0.0, 1.0]), yaw);
        let y = Self::from_axis_angle(Vec3::c([0.0, 1.0, 0.0]), pitch);
        let x = Self::from_axis_angle(Vec3::c([1.0, 0.0, 0.0]), roll);
        z.mul(y).mul(x)
    }
    /// Hamilton product `self other`: first `other`, then `self`.
    #[allow(clippy::should_implement_trait)]
    #[inline(always)]
    pub fn mul(self, other: Self) -> Self {
        let [aw, ax, ay, az] = self.0;
        let [bw, bx, by, bz] = other.0;
        Self([
            aw * bw - ax * bx - ay * by - az * bz,
            aw * bx + ax * bw + ay * bz - az * by,
            aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw,
        ])
    }
    /// The inverse of a unit quaternion.
    #[inline(always)]
    pub fn conj(self) -> Self {
        let [w, x, y, z] = self.0;
        Self([w, -x, -y, -z])
    }
    /// Scales to unit norm.
    #[inline(always)]
    pub fn normalize(self) -> Self {
        let [w, x, y, z] = self.0;
        let n = w.mul_add(w, x.mul_add(x, y.mul_add(y, z * z))).rsqrt();
        Self([w * n, x * n, y * n, z * n])
    }
    /// The rotation matrix of a unit quaternion.
    #[inline(always)]
    pub fn to_mat(self) -> Mat3<V> {
        let [w, x, y, z] = self.0;
        let (x2, y2, z2) = (x + x, y + y, z + z);
        let (xx, yy, zz) = (x * x2, y * y2, z * z2);
        let (xy, xz, yz) = (x * y2, x * z2, y * z2);
        let (wx, wy, wz) = (w * x2, w * y2, w * z2);
        let o = V::one();
        Mat3([
            [o - (yy + zz), xy - wz, xz + wy],
            [xy + wz, o - (xx + zz), yz - wx],
            [xz - wy, yz + wx, o - (xx + yy)],
        ])
    }
    /// Rotates a vector.
    #[inline(always)]
    pub fn rotate(self, v: Vec3<V>) -> Vec3<V> {
        let [w, x, y, z] = self.0;
        let u = Vec3([x, y, z]);
        let t = u.cross(v);
        let t = t + t;
        u.cross_add(t, t.scale_add(w, v))
    }
    /// Turned by the world angular velocity `omega` `[rad/s]` for `dt` `[s]`: first-order step, renormalized.
    #[inline(always)]
    pub fn integrate(self, omega: Vec3<V>, dt: V) -> Self {
        let half = V::c(0.5) * dt;
        let [a, b, c] = omega.scale(half).0;
        let [w, x, y, z] = self.0;
        Self([
            w - (a * x + b * y + c * z),
            x + (a * w + b * z - c * y),
            y + (b * w + c * x - a * z),
            z + (c * w + a * y - b * x),
        ])
        .normalize()
    }
    /// The quaternion of one lane.
    #[inline(always)]
    pub fn lane(&self, i: usize) -> [f64; 4] {
        [self.0[0].lane(i), self.0[1].lane(i), self.0[2].lane(i), self.0[3].lane(i)]
    }
    /// Sets one lane.
    #[inline(always)]
    pub fn set_lane(&mut self, i: usize, q: [f64; 4]) {
        for k in 0..4 {
            self.0[k].set_lane(i, q[k]);
        }
    }
}
