//! Portable lanes: `[f32; N]`, left to the compiler's vectorizer.

use crate::ops::assign_ops;
use crate::{Kernel, MAX_LANES, Mask, Real};

/// `N` lanes of `f32` without any instruction-set requirement. `N` is at most [`MAX_LANES`]: more do not
/// compile.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct F32Array<const N: usize>(pub [f32; N]);

/// Comparison result of [`F32Array`].
#[derive(Clone, Copy, Debug)]
pub struct ArrayMask<const N: usize>([bool; N]);

macro_rules! lane_op {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const N: usize> core::ops::$trait for F32Array<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(mut self, other: Self) -> Self {
                for i in 0..N {
                    self.0[i] $op other.0[i];
                }
                self
            }
        }
    };
}
lane_op!(Add, add, +=);
lane_op!(Sub, sub, -=);
lane_op!(Mul, mul, *=);
lane_op!(Div, div, /=);
assign_ops!(F32Array<N>, const N);

impl<const N: usize> core::ops::Neg for F32Array<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(mut self) -> Self {
        for i in 0..N {
            self.0[i] = -self.0[i];
        }
        self
    }
}

impl<const N: usize> Mask for ArrayMask<N> {
    #[inline(always)]
    fn splat(value: bool) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    fn and(mut self, other: Self) -> Self {
        for i in 0..N {
            self.0[i] &= other.0[i];
        }
        self
    }
    #[inline(always)]
    fn or(mut self, other: Self) -> Self {
        for i in 0..N {
            self.0[i] |= other.0[i];
        }
        self
    }
    #[inline(always)]
    fn not(mut self) -> Self {
        for i in 0..N {
            self.0[i] = !self.0[i];
        }
        self
    }
    #[inline(always)]
    fn any(self) -> bool {
        let mut any = false;
        for i in 0..N {
            any |= self.0[i];
        }
        any
    }
    #[inline(always)]
    fn bits(self) -> u32 {
        let mut bits = 0;
        for i in 0..N {
            bits |= u32::from(self.0[i]) << i;
        }
        bits
    }
    #[inline(always)]
    fn from_bits(bits: u32) -> Self {
        let mut mask = [false; N];
        for i in 0..N {
            mask[i] = bits >> i & 1 == 1;
        }
        Self(mask)
    }
}

impl<const N: usize> Real for F32Array<N> {
    type Scalar = f32;
    type Mask = ArrayMask<N>;
    const LANES: usize = {
        assert!(N <= MAX_LANES, "more lanes than MAX_LANES");
        N
    };
    const NAME: &'static str = "portable f32";

    #[inline(always)]
    fn run<K: Kernel>(kernel: K) -> K::Output {
        kernel.run()
    }
    #[inline(always)]
    fn splat(x: f32) -> Self {
        Self([x; N])
    }
    #[inline(always)]
    fn load(x: &[f32]) -> Self {
        let mut lanes = [0.0; N];
        lanes.copy_from_slice(&x[..N]);
        Self(lanes)
    }
    #[inline(always)]
    fn store(self, out: &mut [f32]) {
        out[..N].copy_from_slice(&self.0);
    }
    // Multiply and add round twice: a fused operation without hardware support would be a library call.
    #[inline(always)]
    fn mul_add(self, b: Self, c: Self) -> Self {
        self * b + c
    }
    #[inline(always)]
    fn neg_mul_add(self, b: Self, c: Self) -> Self {
        c - self * b
    }
    #[inline(always)]
    fn max(mut self, other: Self) -> Self {
        for i in 0..N {
            self.0[i] = if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] };
        }
        self
    }
    #[inline(always)]
    fn min(mut self, other: Self) -> Self {
        for i in 0..N {
            self.0[i] = if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] };
        }
        self
    }
    #[inline(always)]
    fn abs(mut self) -> Self {
        for i in 0..N {
            self.0[i] = self.0[i].abs();
        }
        self
    }
    #[inline(always)]
    fn recip(self) -> Self {
        Self::splat(1.0) / self
    }
    #[inline(always)]
    fn rsqrt(self) -> Self {
        self.sqrt().recip()
    }
    #[inline(always)]
    fn sqrt(mut self) -> Self {
        for i in 0..N {
            self.0[i] = self.0[i].sqrt();
        }
        self
    }
    #[inline(always)]
    fn floor(mut self) -> Self {
        for i in 0..N {
            let truncated = self.0[i] as i32 as f32;
            self.0[i] = if truncated > self.0[i] { truncated - 1.0 } else { truncated };
        }
        self
    }
    #[inline(always)]
    fn exp2_int(mut self) -> Self {
        for i in 0..N {
            self.0[i] = f32::from_bits(((self.0[i] as i32 + 127) << 23) as u32);
        }
        self
    }
    #[inline(always)]
    fn lt(self, other: Self) -> ArrayMask<N> {
        let mut mask = [false; N];
        for i in 0..N {
            mask[i] = self.0[i] < other.0[i];
        }
        ArrayMask(mask)
    }
    #[inline(always)]
    fn le(self, other: Self) -> ArrayMask<N> {
        let mut mask = [false; N];
        for i in 0..N {
            mask[i] = self.0[i] <= other.0[i];
        }
        ArrayMask(mask)
    }
    #[inline(always)]
    fn select(mask: ArrayMask<N>, if_true: Self, mut if_false: Self) -> Self {
        for i in 0..N {
            if_false.0[i] = if mask.0[i] { if_true.0[i] } else { if_false.0[i] };
        }
        if_false
    }
}
