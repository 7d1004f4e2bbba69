//! 16 lanes of `f32` in AVX-512 registers.

use core::arch::x86_64::*;
use std::sync::LazyLock;

use crate::ops::{assign_ops, intrinsic_method, intrinsic_op, lane_access};
use crate::{Kernel, Mask, Real};

// SAFETY (all intrinsics in this file): a value of these types exists only on a CPU with AVX-512: kernels are entered
// through `Real::run`, which checks the CPU, and `Isa` hands out this type only after detection.

/// 16 lanes of `f32`, AVX-512.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct F32x16(pub __m512);

intrinsic_op!(F32x16, Add, add, _mm512_add_ps);
intrinsic_op!(F32x16, Sub, sub, _mm512_sub_ps);
intrinsic_op!(F32x16, Mul, mul, _mm512_mul_ps);
intrinsic_op!(F32x16, Div, div, _mm512_div_ps);
assign_ops!(F32x16);

/// Comparison result of [`F32x16`]: bit `i` is lane `i`.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Mask16(__mmask16);

impl core::ops::Neg for F32x16 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))) }
    }
}

impl Mask for Mask16 {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self(if value { 0xffff } else { 0 })
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
    #[inline(always)]
    fn not(self) -> Self {
        Self(!self.0)
    }
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        u32::from(self.0)
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        Self(bits as u16)
    }
}

// Never inlined: kernels stay separate functions, which keeps the optimizer's time linear in their number.
#[inline(never)]
#[target_feature(enable = "avx512f,avx512dq,avx512vl,avx2,fma")]
fn enter<K: Kernel>(kernel: K) -> K::Output {
    kernel.run()
}

impl F32x16 {
    /// True if this CPU has the instructions.
    #[inline]
    pub fn available() -> bool {
        // Asked at every entry of a kernel.
        static AVAILABLE: LazyLock<bool> = LazyLock::new(|| {
            is_x86_feature_detected!("avx512f")
                && is_x86_feature_detected!("avx512dq")
                && is_x86_feature_detected!("avx512vl")
                && is_x86_feature_detected!("fma")
        });
        *AVAILABLE
    }
}

impl Real for F32x16 {
    type Scalar = f32;
    type Mask = Mask16;
    const LANES: usize = 16;
    const NAME: &'static str = "AVX-512 f32 x 16";

    #[inline(always)]
    fn run<K: Kernel>(kernel: K) -> K::Output {
        assert!(Self::available(), "this CPU has no AVX-512 F, DQ and VL");
        // SAFETY: the features are present, checked just above.
        unsafe { enter(kernel) }
    }
    lane_access!(16);
    intrinsic_method!(mul_add(b, c), _mm512_fmadd_ps);
    intrinsic_method!(neg_mul_add(b, c), _mm512_fnmadd_ps);
    intrinsic_method!(max(other), _mm512_max_ps);
    intrinsic_method!(min(other), _mm512_min_ps);
    intrinsic_method!(abs(), _mm512_abs_ps);
    intrinsic_method!(sqrt(), _mm512_sqrt_ps);
    #[inline(always)]
    fn splat(x: f32) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm512_set1_ps(x)) }
    }
    #[inline(always)]
    fn load(x: &[f32]) -> Self {
        let x = &x[..16];
        // SAFETY: sixteen elements are readable; the load is unaligned.
        unsafe { Self(_mm512_loadu_ps(x.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, out: &mut [f32]) {
        let out = &mut out[..16];
        // SAFETY: sixteen elements are writable; the store is unaligned.
        unsafe { _mm512_storeu_ps(out.as_mut_ptr(), self.0) }
    }
    #[inline(always)]
    fn recip(self) -> Self {
        // One Newton step on the 14-bit estimate.
        // SAFETY: see the top of the file.
        let estimate = unsafe { Self(_mm512_rcp14_ps(self.0)) };
        let error = self.neg_mul_add(estimate, Self::splat(1.0));
        estimate.mul_add(error, estimate)
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        // One Newton step on the 14-bit estimate.
        // SAFETY: see the top of the file.
        let estimate = unsafe { Self(_mm512_rsqrt14_ps(self.0)) };
        let error = (self * estimate).neg_mul_add(estimate, Self::splat(3.0));
        estimate * Self::splat(0.5) * error
    }
    #[inline(always)]
    fn floor(self) -> Self {
        // SAFETY: see the top of the file. 0x01 rounds toward minus infinity with scale 0.
        unsafe { Self(_mm512_roundscale_ps::<0x01>(self.0)) }
    }
    #[inline(always)]
    fn exp2_int(self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm512_scalef_ps(_mm512_set1_ps(1.0), self.0)) }
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Mask16 {
        // SAFETY: see the top of the file.
        unsafe { Mask16(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> Mask16 {
        // SAFETY: see the top of the file.
        unsafe { Mask16(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)) }
    }
    #[inline(always)]
    fn select(mask: Mask16, if_true: Self, if_false: Self) -> Self {
        // SAFETY: see the top of the file.
        unsafe { Self(_mm512_mask_blend_ps(mask.0, if_false.0, if_true.0)) }
    }
}
