//! Plain loops: what the other kernels are tested against, and what runs where the processor has no bfloat16.

use super::round::{flush, pair, widen};
use super::{PANEL, Panels, Rows};
use crate::matrix::{Mat, MatMut};

/// `sum + x y` of one pair as `VDPBF16PS` has it: the odd product first, each step rounded once, denormal numbers as zero.
#[inline(always)]
fn add_pair(sum: f32, x: u32, y: u32) -> f32 {
    let (low, high) = (|w: u32| widen(w as u16), |w: u32| widen((w >> 16) as u16));
    let odd = flush(high(x).mul_add(high(y), sum));
    flush(low(x).mul_add(low(y), odd))
}

/// See [`super::Kernel::multiply`].
pub(super) fn multiply(mut dst: MatMut<'_, f32>, a: &Rows, b: &Panels, accumulate: bool) {
    let pairs = a.inner().div_ceil(2);
    for r in 0..a.rows() {
        let words = &a.words()[r * a.stride()..][..pairs];
        let row = dst.row(r);
        for (k, out) in row.chunks_mut(PANEL).enumerate() {
            let mut sums = [0.0; PANEL];
            if accumulate {
                for (sum, x) in sums.iter_mut().zip(&*out) {
                    *sum = flush(*x);
                }
            }
            for (x, ys) in words.iter().zip(b.panel(k).chunks_exact(PANEL)) {
                for (sum, y) in sums.iter_mut().zip(ys) {
                    *sum = add_pair(*sum, *x, *y);
                }
            }
            out.copy_from_slice(&sums[..out.len()]);
        }
    }
}

/// See [`super::Kernel::pack_row`].
pub(super) fn pack_row(row: &[f32], words: &mut [u32]) {
    let at = |i: usize| row.get(i).copied().unwrap_or(0.0);
    for (p, word) in words.iter_mut().enumerate() {
        *word = pair(at(2 * p), at(2 * p + 1));
    }
}

/// See [`super::Kernel::pack_panels`].
pub(super) fn pack_panels(source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
    let at = |i: usize, c: usize| if i < source.rows() && c < source.cols() { source.get(i, c) } else { 0.0 };
    for (n, panel) in panels.chunks_exact_mut(size).enumerate() {
        for (k, word) in panel.iter_mut().enumerate() {
            let (p, c) = (k / PANEL, n * PANEL + k % PANEL);
            *word = pair(at(2 * p, c), at(2 * p + 1, c));
        }
    }
}
