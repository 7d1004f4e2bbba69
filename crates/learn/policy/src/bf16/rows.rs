//! The left operand of a product.

use super::round::pair;
use super::{Kernel, PAIR_STEP, ROW_STEP};
use crate::matrix::Mat;

/// A matrix `[rows, inner]` in bfloat16, row by row, two numbers of the inner dimension a word. Rows and pairs are padded with zeros.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Rows {
    words: Vec<u32>,
    rows: usize,
    inner: usize,
}

impl Rows {
    /// Rounds and packs a matrix.
    pub fn new(kernel: Kernel, source: Mat<'_, f32>) -> Self {
        let mut rows = Self::default();
        rows.pack(kernel, source);
        rows
    }

    /// Rounds and packs another matrix in this one's place.
    pub fn pack(&mut self, kernel: Kernel, source: Mat<'_, f32>) {
        (self.rows, self.inner) = (source.rows(), source.cols());
        let stride = self.stride();
        self.words.resize(self.rows.next_multiple_of(ROW_STEP) * stride, 0);
        for (r, words) in self.words.chunks_exact_mut(stride.max(1)).enumerate() {
            if r >= self.rows {
                words.fill(0);
            } else if let Some(row) = source.contiguous_row(r) {
                kernel.pack_row(row, words);
            } else {
                let at = |i: usize| if i < self.inner { source.get(r, i) } else { 0.0 };
                for (p, word) in words.iter_mut().enumerate() {
                    *word = pair(at(2 * p), at(2 * p + 1));
                }
            }
        }
    }

    /// Number of rows, without padding.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Inner dimension, without padding.
    pub fn inner(&self) -> usize {
        self.inner
    }

    /// Words from row to row.
    pub(super) fn stride(&self) -> usize {
        self.inner.div_ceil(2).next_multiple_of(PAIR_STEP)
    }

    /// All words.
    pub(super) fn words(&self) -> &[u32] {
        &self.words
    }
}
