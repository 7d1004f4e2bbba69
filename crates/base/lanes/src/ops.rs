//! Operators shared by the lane types.

macro_rules! assign_ops {
    ($t:ty $(, const $n:ident)?) => {
        impl $(<const $n: usize>)? core::ops::AddAssign for $t {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                *self = *self + other;
            }
        }
        impl $(<const $n: usize>)? core::ops::SubAssign for $t {
            #[inline(always)]
            fn sub_assign(&mut self, other: Self) {
                *self = *self - other;
            }
        }
        impl $(<const $n: usize>)? core::ops::MulAssign for $t {
            #[inline(always)]
            fn mul_assign(&mut self, other: Self) {
                *self = *self * other;
            }
        }
    };
}
pub(crate) use assign_ops;

/// Binary operator by one intrinsic.
macro_rules! intrinsic_op {
    ($t:ident, $trait:ident, $method:ident, $intrinsic:ident) => {
        impl core::ops::$trait for $t {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: a value of this type exists only on a CPU with the instruction set (see `Isa`).
                unsafe { $t($intrinsic(self.0, other.0)) }
            }
        }
    };
}

/// Method of [`crate::Real`] that is one intrinsic.
macro_rules! intrinsic_method {
    ($name:ident($($argument:ident),*), $intrinsic:ident) => {
        #[inline(always)]
        fn $name(self $(, $argument: Self)*) -> Self {
            // SAFETY: a value of this type exists only on a CPU with the instruction set (see `Isa`).
            unsafe { Self($intrinsic(self.0 $(, $argument.0)*)) }
        }
    };
}
#[cfg(target_arch = "x86_64")]
pub(crate) use {intrinsic_method, intrinsic_op};

/// Single lanes in place: outside of kernels the instructions of whole vectors are function calls.
macro_rules! lane_access {
    ($n:literal) => {
        #[inline(always)]
        fn lane(&self, i: usize) -> f64 {
            assert!(i < $n, "lane {i} of {}", $n);
            // SAFETY: the type is transparent over a vector of `$n` consecutive `f32`, and `i` is one of them.
            unsafe { f64::from(*core::ptr::from_ref(self).cast::<f32>().add(i)) }
        }
        #[inline(always)]
        fn set_lane(&mut self, i: usize, x: f64) {
            assert!(i < $n, "lane {i} of {}", $n);
            // SAFETY: the type is transparent over a vector of `$n` consecutive `f32`, and `i` is one of them.
            unsafe { *core::ptr::from_mut(self).cast::<f32>().add(i) = crate::Scalar::from_f64(x) }
        }
    };
}
pub(crate) use lane_access;
