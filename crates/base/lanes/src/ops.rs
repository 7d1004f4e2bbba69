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
