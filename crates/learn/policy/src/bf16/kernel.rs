//! The ways in which a product can be computed.

use super::{Panels, Rows, portable};
#[cfg(target_arch = "x86_64")]
use super::{amx, avx512};
use crate::matrix::{Mat, MatMut};

/// Instructions of a product. A value exists only where the processor has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Kernel(Kind);

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Portable,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "x86_64")]
    Amx,
}

impl Kernel {
    /// Plain loops, on any processor. Slow.
    pub const PORTABLE: Self = Self(Kind::Portable);

    /// AVX512-BF16, where the processor has it.
    pub fn avx512() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if avx512::available() {
            return Some(Self(Kind::Avx512));
        }
        None
    }

    /// AMX tiles, where the processor has them and the kernel of the operating system grants them.
    pub fn amx() -> Option<Self> {
        #[cfg(target_arch = "x86_64")]
        if amx::available() {
            return Some(Self(Kind::Amx));
        }
        None
    }

    /// All kernels that this machine has, the portable one first.
    pub fn available() -> Vec<Self> {
        [Some(Self::PORTABLE), Self::avx512(), Self::amx()].into_iter().flatten().collect()
    }

    /// `portable`, `avx512_bf16` or `amx_bf16`.
    pub fn name(self) -> &'static str {
        match self.0 {
            Kind::Portable => "portable",
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => "avx512_bf16",
            #[cfg(target_arch = "x86_64")]
            Kind::Amx => "amx_bf16",
        }
    }

    /// `dst = a b`, or `dst += a b` if `accumulate`, on this thread. A number of `dst` depends on its row of `a` and its column of `b`
    /// alone: not on where they lie, nor on what lies next to them.
    ///
    /// # Panics
    /// If the shapes do not fit.
    pub fn multiply(self, dst: MatMut<'_, f32>, a: &Rows, b: &Panels, accumulate: bool) {
        assert!(
            dst.rows() == a.rows() && dst.cols() == b.cols() && a.inner() == b.inner(),
            "[{}, {}] = [{}, {}] [{}, {}] does not fit",
            dst.rows(),
            dst.cols(),
            a.rows(),
            a.inner(),
            b.inner(),
            b.cols()
        );
        match self.0 {
            Kind::Portable => portable::multiply(dst, a, b, accumulate),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 => avx512::multiply(dst, a, b, accumulate),
            #[cfg(target_arch = "x86_64")]
            Kind::Amx => amx::multiply(dst, a, b, accumulate),
        }
    }

    /// Rounds `row` to pairs, zeros beyond its end; there is room for all of them, and a multiple of [`super::PAIR_STEP`] words.
    pub(super) fn pack_row(self, row: &[f32], words: &mut [u32]) {
        match self.0 {
            Kind::Portable => portable::pack_row(row, words),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 | Kind::Amx => avx512::pack_row(row, words),
        }
    }

    /// Rounds `source` `[inner, cols]` to pairs in panels of `size` words, zeros beyond its ends.
    pub(super) fn pack_panels(self, source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
        match self.0 {
            Kind::Portable => portable::pack_panels(source, size, panels),
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 | Kind::Amx if source.contiguous_row(0).is_some() => {
                avx512::pack_panels(source, size, panels);
            }
            #[cfg(target_arch = "x86_64")]
            Kind::Avx512 | Kind::Amx => avx512::pack_panels_of_transpose(source.t(), size, panels),
        }
    }
}
