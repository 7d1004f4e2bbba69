//! The right operand of a product.

use super::{Kernel, PAIR_STEP, PANEL};
use crate::matrix::Mat;

/// A matrix `[inner, cols]` in bfloat16, in panels of 48 columns: a panel has a row of 48 words for every two numbers of the inner
/// dimension. Columns and pairs are padded with zeros.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Panels {
    words: Vec<u32>,
    inner: usize,
    cols: usize,
}

impl Panels {
    /// Rounds and packs a matrix.
    pub fn new(kernel: Kernel, source: Mat<'_, f32>) -> Self {
        let mut panels = Self::default();
        panels.pack(kernel, source);
        panels
    }

    /// Rounds and packs another matrix in this one's place.
    pub fn pack(&mut self, kernel: Kernel, source: Mat<'_, f32>) {
        (self.inner, self.cols) = (source.rows(), source.cols());
        let size = self.depth() * PANEL;
        self.words.resize(self.cols.div_ceil(PANEL) * size, 0);
        if size > 0 {
            kernel.pack_panels(source, size, &mut self.words);
        }
    }

    /// Inner dimension, without padding.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// Number of columns, without padding.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Rows of words in a panel.
    pub(super) fn depth(&self) -> usize {
        self.inner.div_ceil(2).next_multiple_of(PAIR_STEP)
    }

    /// The words of panel `k`.
    pub(super) fn panel(&self, k: usize) -> &[u32] {
        let size = self.depth() * PANEL;
        &self.words[k * size..(k + 1) * size]
    }
}
