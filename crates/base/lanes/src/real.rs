//! The traits that numeric code is written over.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use crate::functions;

/// No lane type has more lanes: the length of buffers with one element per lane.
pub const MAX_LANES: usize = 16;

/// The element type of a lane: `f32` in training, `f64` in validation.
pub trait Scalar: Copy + Default + Debug + PartialOrd + Send + Sync + 'static {
    /// Rounds to the element type.
    fn from_f64(x: f64) -> Self;
    /// Widens exactly.
    fn to_f64(self) -> f64;
}

impl Scalar for f32 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
}

impl Scalar for f64 {
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
}

/// One boolean per lane.
pub trait Mask: Copy + Debug + Send + Sync + 'static {
    /// The same value in every lane.
    fn splat(value: bool) -> Self;
    /// Lane-wise and.
    fn and(self, other: Self) -> Self;
    /// Lane-wise or.
    fn or(self, other: Self) -> Self;
    /// Lane-wise negation.
    fn not(self) -> Self;
    /// True if any lane is set.
    fn any(self) -> bool;
    /// Bit `i` is lane `i`.
    fn bits(self) -> u32;
    /// Lane `i` from bit `i`.
    fn from_bits(bits: u32) -> Self;
    /// The value of one lane.
    #[inline(always)]
    fn lane(self, i: usize) -> bool {
        self.bits() >> i & 1 == 1
    }
}

/// A computation that is entered with an instruction set enabled, see [`Real::run`].
pub trait Kernel {
    /// What the computation returns.
    type Output;
    /// The body. Mark the implementation, and all that it calls, `#[inline(always)]`.
    fn run(self) -> Self::Output;
}

/// A number, or one number per SIMD lane.
///
/// All operations act lane by lane; there is no operation that mixes lanes. Comparisons with NaN are false.
pub trait Real:
    Copy
    + Debug
    + Send
    + Sync
    + 'static
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Element type.
    type Scalar: Scalar;
    /// Result of comparisons.
    type Mask: Mask;
    /// Number of lanes, at most [`MAX_LANES`].
    const LANES: usize;
    /// Name for logs and benchmarks.
    const NAME: &'static str;

    /// Enters `kernel` with this type's instruction set enabled.
    ///
    /// # Panics
    /// If the CPU lacks the instruction set.
    fn run<K: Kernel>(kernel: K) -> K::Output;

    /// The same value in every lane.
    fn splat(x: Self::Scalar) -> Self;
    /// Reads `LANES` consecutive elements. Panics if `x` is shorter.
    fn load(x: &[Self::Scalar]) -> Self;
    /// Writes `LANES` consecutive elements. Panics if `out` is shorter.
    fn store(self, out: &mut [Self::Scalar]);
    /// `self * b + c`.
    fn mul_add(self, b: Self, c: Self) -> Self;
    /// `c - self * b`.
    fn neg_mul_add(self, b: Self, c: Self) -> Self;
    /// The larger; of a NaN in `self` and a number, the number.
    fn max(self, other: Self) -> Self;
    /// The smaller; of a NaN in `self` and a number, the number.
    fn min(self, other: Self) -> Self;
    /// Absolute value.
    fn abs(self) -> Self;
    /// `1 / self`, to within 2 units in the last place.
    fn recip(self) -> Self;
    /// `1 / sqrt(self)`, relative error below 1e-6 in `f32`; `self` must be positive and normal.
    fn rsqrt(self) -> Self;
    /// Square root.
    fn sqrt(self) -> Self;
    /// Rounds toward minus infinity.
    fn floor(self) -> Self;
    /// `2^self` for integral `self` in [-126, 127].
    fn exp2_int(self) -> Self;
    /// `self < other`.
    fn lt(self, other: Self) -> Self::Mask;
    /// `self <= other`.
    fn le(self, other: Self) -> Self::Mask;
    /// `if_true` where `mask` is set, else `if_false`.
    fn select(mask: Self::Mask, if_true: Self, if_false: Self) -> Self;
    /// Sine and cosine of any angle `[rad]`; absolute error below 2e-7 in `f32` for |x| < 100.
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        functions::sin_cos(self)
    }
    /// `e^self`; arguments below -87 give 0 in `f32`. Relative error below 4e-7 in `f32`.
    #[inline(always)]
    fn exp(self) -> Self {
        functions::exp(self)
    }
    /// Angle of the point (`x`, `self`) `[rad]`. Absolute error below 1e-6 in `f32`. `atan2(0, 0)` is 0.
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        functions::atan2(self, x)
    }

    /// A constant in every lane.
    #[inline(always)]
    fn c(x: f64) -> Self {
        Self::splat(Self::Scalar::from_f64(x))
    }
    /// Zero in every lane.
    #[inline(always)]
    fn zero() -> Self {
        Self::c(0.0)
    }
    /// One in every lane.
    #[inline(always)]
    fn one() -> Self {
        Self::c(1.0)
    }
    /// `self > other`.
    #[inline(always)]
    fn gt(self, other: Self) -> Self::Mask {
        other.lt(self)
    }
    /// `self >= other`.
    #[inline(always)]
    fn ge(self, other: Self) -> Self::Mask {
        other.le(self)
    }
    /// Limits to `[lo, hi]`; NaN becomes `lo`.
    #[inline(always)]
    fn clamp(self, lo: Self, hi: Self) -> Self {
        self.max(lo).min(hi)
    }
    /// Hyperbolic tangent.
    #[inline(always)]
    fn tanh(self) -> Self {
        let e = (self.abs() * Self::c(-2.0)).exp();
        let t = (Self::one() - e) / (Self::one() + e);
        Self::select(self.lt(Self::zero()), -t, t)
    }
    /// True where the lane is neither infinite nor NaN.
    #[inline(always)]
    fn is_finite(self) -> Self::Mask {
        (self * Self::zero()).le(Self::zero())
    }
    /// The value of lane `i`.
    #[inline(always)]
    fn lane(&self, i: usize) -> f64 {
        let mut lanes = [Self::Scalar::default(); MAX_LANES];
        self.store(&mut lanes[..Self::LANES]);
        lanes[..Self::LANES][i].to_f64()
    }
    /// Sets lane `i`.
    #[inline(always)]
    fn set_lane(&mut self, i: usize, x: f64) {
        let mut lanes = [Self::Scalar::default(); MAX_LANES];
        self.store(&mut lanes[..Self::LANES]);
        lanes[..Self::LANES][i] = Self::Scalar::from_f64(x);
        *self = Self::load(&lanes[..Self::LANES]);
    }
}
