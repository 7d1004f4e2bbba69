//! Elementary functions from arithmetic only, shared by the `f32` lane types.
//!
//! Polynomials are Taylor or minimax fits on the reduced range; accuracies are stated in [`crate::Real`] and tested.

use crate::Real;

/// Sine and cosine: reduction to [-pi, pi], half-angle Taylor polynomials, angle doubling.
#[inline(always)]
pub(crate) fn sin_cos<V: Real>(x: V) -> (V, V) {
    let turns = x.mul_add(V::c(0.5 / core::f64::consts::PI), V::c(0.5)).floor();
    // Two-part 2 pi keeps the reduction exact for the angles that joints and headings reach.
    let x = turns.neg_mul_add(V::c(6.283_203_125), x);
    let x = turns.neg_mul_add(V::c(core::f64::consts::TAU - 6.283_203_125), x);
    let y = x * V::c(0.5);
    let z = y * y;
    let s = V::c(-2.505_210_84e-8).mul_add(z, V::c(2.755_731_92e-6));
    let s = s.mul_add(z, V::c(-1.984_126_98e-4)).mul_add(z, V::c(8.333_333_33e-3));
    let s = s.mul_add(z, V::c(-1.666_666_67e-1)).mul_add(z * y, y);
    let c = V::c(2.087_675_70e-9).mul_add(z, V::c(-2.755_731_92e-7));
    let c = c.mul_add(z, V::c(2.480_158_73e-5)).mul_add(z, V::c(-1.388_888_89e-3));
    let c = c.mul_add(z, V::c(4.166_666_67e-2)).mul_add(z, V::c(-0.5)).mul_add(z, V::one());
    let s2 = s + s;
    (s2 * c, s2.neg_mul_add(s, V::one()))
}

/// Exponential: `2^k * 2^f` with a degree-6 polynomial for `|f| <= 0.5`.
#[inline(always)]
pub(crate) fn exp<V: Real>(x: V) -> V {
    let underflow = x.lt(V::c(-87.0));
    let x = x.clamp(V::c(-87.0), V::c(88.0));
    let k = x.mul_add(V::c(core::f64::consts::LOG2_E), V::c(0.5)).floor();
    let r = k.neg_mul_add(V::c(0.693_359_375), x);
    let r = k.neg_mul_add(V::c(core::f64::consts::LN_2 - 0.693_359_375), r);
    let p = V::c(1.0 / 720.0).mul_add(r, V::c(1.0 / 120.0)).mul_add(r, V::c(1.0 / 24.0));
    let p = p.mul_add(r, V::c(1.0 / 6.0)).mul_add(r, V::c(0.5)).mul_add(r, V::one()).mul_add(r, V::one());
    V::select(underflow, V::zero(), p * k.exp2_int())
}

/// Arc tangent of `y / x` in all quadrants: reduction to [0, 1], then to [0, tan(pi/8)].
#[inline(always)]
pub(crate) fn atan2<V: Real>(y: V, x: V) -> V {
    let (ay, ax) = (y.abs(), x.abs());
    let swap = ax.lt(ay);
    let (num, den) = (ax.min(ay), ax.max(ay));
    let t = num / den.max(V::c(1e-30));
    let big = V::c(0.414_213_562).lt(t);
    let t = V::select(big, (t - V::one()) / (t + V::one()), t);
    let z = t * t;
    let p = V::c(8.053_744_5e-2).mul_add(z, V::c(-1.387_768_6e-1));
    let p = p.mul_add(z, V::c(1.997_771_1e-1)).mul_add(z, V::c(-3.333_294_9e-1)).mul_add(z * t, t);
    let a = p + V::select(big, V::c(core::f64::consts::FRAC_PI_4), V::zero());
    let a = V::select(swap, V::c(core::f64::consts::FRAC_PI_2) - a, a);
    let a = V::select(x.lt(V::zero()), V::c(core::f64::consts::PI) - a, a);
    let a = V::select(y.lt(V::zero()), -a, a);
    V::select(den.le(V::zero()), V::zero(), a)
}
