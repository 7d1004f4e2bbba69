//! 8 lanes of `f32` in AVX2 registers.

use core::arch::x86_64::*;

use crate::ops::{assign_ops, intrinsic_method, intrinsic_op, lane_access};
use crate::{Kernel, Mask, Real};

// SAFETY (all intrinsics in this file): a value of these types exists only on a CPU with AVX2: kernels are entered
// through `Real::run`, which checks the CPU, and `Isa` hands out this type only after detection.

/// 8 lanes of `f32`, AVX2.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F32x8(pub __m256);

intrinsic_op!(F32x8, Add, add, _mm256_add_ps);
intrinsic_op!(F32x8, Sub, sub, _mm256_sub_ps);
intrinsic_op!(F32x8, Mul, mul, _mm256_mul_ps);
intrinsic_op!(F32x8, Div, div, _mm256_div_ps);
assign_ops!(F32x8);

/// Comparison result of [`F32x8`]: all bits of a lane set or clear.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Mask8(__m256);

impl core::ops::Neg for F32x8 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))) }
    }
}

impl Mask for Mask8 {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self::from_bits(if value { 0xff } else { 0 })
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_and_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_or_ps(self.0, other.0)) }
    }
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_xor_ps(self.0, _mm256_castsi256_ps(_mm256_set1_epi32(-1)))) }
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: see the top of the file.
        unsafe { _mm256_movemask_ps(self.0) as u32 }
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        // SAFETY: see the top of the file.
        unsafe {
            let lane_bit = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            let set = _mm256_and_si256(_mm256_set1_epi32(bits as i32), lane_bit);
            Self(_mm256_castsi256_ps(_mm256_cmpeq_epi32(set, lane_bit)))
        }
    }
}

// Never inlined: kernels stay separate functions, which keeps the optimizer's time linear in their number.
#[inline(never)]
#[target_feature(enable = "avx2,fma")]
fn enter<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

impl F32x8 {
    /// True if this CPU has the instructions.
    pub fn available() -> bool {
        is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma")
    }
}

impl Real for F32x8 {
    type Scalar = f32;
    type Mask = Mask8;
    const LANES: usize = 8;
    const NAME: &'static str = "AVX2 f32 x 8";

    #[inline(always)]
    fn run<K: Kernel>(kernel: K) -> K::Output {
        assert!(Self::available(), "this CPU has no AVX2 with FMA");
        // SAFETY: the features are present, checked just above.
        unsafe { enter(kernel) }
    }
    lane_access!(8);
    intrinsic_method!(mul_add(b, c), _mm256_fmadd_ps);
    intrinsic_method!(neg_mul_add(b, c), _mm256_fnmadd_ps);
    intrinsic_method!(max(other), _mm256_max_ps);
    intrinsic_method!(min(other), _mm256_min_ps);
    intrinsic_method!(sqrt(), _mm256_sqrt_ps);
    intrinsic_method!(floor(), _mm256_floor_ps);
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_set1_ps(x)) }
    }
    #[inline(always)]
    fn load(x: &[f32]) -> Self {
        let x = &x[..8];
        // SAFETY: eight elements are readable; the load is unaligned.
        unsafe { Self(_mm256_loadu_ps(x.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, out: &mut [f32]) {
        let out = &mut out[..8];
        // SAFETY: eight elements are writable; the store is unaligned.
        unsafe { _mm256_storeu_ps(out.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }
    #[inline(always)]
    fn recip(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_div_ps(_mm256_set1_ps(1.0), self.0)) }
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        // One Newton step on the 12-bit estimate.
        // SAFETY: see the top of the file.
        let estimate = unsafe { Self(_mm256_rsqrt_ps(self.0)) };
        let error = (self * estimate).neg_mul_add(estimate, Self::splat(3.0));
        estimate * Self::splat(0.5) * error
    }
    #[inline(always)]
    fn exp2_int(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe {
            let exponent = _mm256_add_epi32(_mm256_cvtps_epi32(self.0), _mm256_set1_epi32(127));
            Self(_mm256_castsi256_ps(_mm256_slli_epi32::<23>(exponent)))
        }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask8 {
        // SAFETY: see the top of the file.
        unsafe { Mask8(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask8 {
        // SAFETY: see the top of the file.
        unsafe { Mask8(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn select(mask: Mask8, if_true: Self, if_false: Self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm256_blendv_ps(if_false.0, if_true.0, mask.0)) }
    }
}
