//! AVX512-BF16: 8 rows by 48 columns of sums in registers, one `VDPBF16PS` for 16 columns and two inner numbers.
#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m512, __m512bh, __m512i, __mmask16, _MM_HINT_T0, _mm_prefetch, _mm512_cvtne2ps_pbh, _mm512_dpbf16_ps,
    _mm512_loadu_si512, _mm512_mask_storeu_ps, _mm512_maskz_loadu_ps, _mm512_permutexvar_epi16,
    _mm512_set1_epi32, _mm512_setzero_ps, _mm512_setzero_si512, _mm512_shuffle_i32x4, _mm512_storeu_si512,
    _mm512_unpackhi_epi32, _mm512_unpackhi_epi64, _mm512_unpacklo_epi32, _mm512_unpacklo_epi64,
};
use core::mem::transmute;

use super::{PANEL, Panels, Rows};
use crate::matrix::{Mat, MatMut};

/// Numbers of a vector.
const LANES: usize = 16;
/// Rows whose sums are kept in registers: 8 x 3 vectors of sums, 3 of the right operand, 1 of the left, of 32 registers.
const BLOCK: usize = 8;
/// Rows that are prefetched ahead of their use: stored observations do not fit the caches.
const AHEAD: usize = 8;

/// True if the processor has what this file needs.
pub(super) fn available() -> bool {
    is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512bw")
        && is_x86_feature_detected!("avx512bf16")
}

/// The first `count` lanes; all of them from 16 on.
fn mask(count: usize) -> __mmask16 {
    if count >= LANES { !0 } else { (1 << count) - 1 }
}

/// See [`super::Kernel::multiply`], which has compared the shapes.
pub(super) fn multiply(dst: MatMut<'_, f32>, a: &Rows, b: &Panels, accumulate: bool) {
    // SAFETY: a `Kernel` of this kind exists only where `available()` was true.
    unsafe { multiply_here(dst, a, b, accumulate) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn multiply_here(mut dst: MatMut<'_, f32>, a: &Rows, b: &Panels, accumulate: bool) {
    let pairs = a.inner().div_ceil(2);
    for first_col in (0..dst.cols()).step_by(PANEL) {
        let panel = b.panel(first_col / PANEL);
        let cols = PANEL.min(dst.cols() - first_col);
        for first_row in (0..a.rows()).step_by(BLOCK) {
            let rows = BLOCK.min(a.rows() - first_row);
            // Rows are padded to a multiple of `BLOCK`, so that eight can be read.
            let words = &a.words()[first_row * a.stride()..][..BLOCK * a.stride()];
            let tile = Tile { words, stride: a.stride(), panel, pairs, accumulate };
            let (out, step) = dst.block(first_row, rows, first_col, cols);
            match cols.div_ceil(LANES) {
                1 => tile.run::<1>(out, step, rows, cols),
                2 => tile.run::<2>(out, step, rows, cols),
                _ => tile.run::<3>(out, step, rows, cols),
            }
        }
    }
}

/// One block of sums.
#[derive(Clone, Copy)]
struct Tile<'a> {
    /// Eight rows of the left operand.
    words: &'a [u32],
    /// Words from row to row.
    stride: usize,
    /// Rows of 48 words of the right operand.
    panel: &'a [u32],
    pairs: usize,
    accumulate: bool,
}

impl Tile<'_> {
    /// Computes `rows` rows of `cols` columns, which fill `C` vectors; they go to `out`, whose rows are `step` apart.
    #[inline]
    #[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
    fn run<const C: usize>(self, out: &mut [f32], step: usize, rows: usize, cols: usize) {
        let Tile { words, stride, panel, pairs, accumulate } = self;
        assert!(pairs <= stride && words.len() >= BLOCK * stride && panel.len() >= pairs * PANEL);
        assert!(rows <= BLOCK && cols <= C * LANES && cols > (C - 1) * LANES && C * LANES <= PANEL);
        assert!(rows > 0 && out.len() >= (rows - 1) * step + cols);
        let last = mask(cols - (C - 1) * LANES);
        let mask_of = |c: usize| if c + 1 == C { last } else { !0 };
        let mut sums = [[_mm512_setzero_ps(); C]; BLOCK];
        if accumulate {
            for (r, sums) in sums.iter_mut().enumerate().take(rows) {
                for (c, sum) in sums.iter_mut().enumerate() {
                    // SAFETY: the lanes that the mask lets through are elements `r step + 16 c ..` below `r step + cols` of `out`.
                    *sum =
                        unsafe { _mm512_maskz_loadu_ps(mask_of(c), out.as_ptr().add(r * step + c * LANES)) };
                }
            }
        }
        let (left, right) = (words.as_ptr(), panel.as_ptr());
        for p in 0..pairs {
            let mut y = [_mm512_setzero_si512(); C];
            for (c, y) in y.iter_mut().enumerate() {
                // SAFETY: `p < pairs`, and a row of the panel has 48 words, at least `16 C`.
                *y = unsafe { _mm512_loadu_si512(right.add(p * PANEL + c * LANES).cast()) };
            }
            for (r, sums) in sums.iter_mut().enumerate() {
                // SAFETY: `r < 8` and `p < pairs <= stride`, and there are `8 stride` words.
                let x = _mm512_set1_epi32(unsafe { left.add(r * stride + p).read() }.cast_signed());
                for (sum, y) in sums.iter_mut().zip(y) {
                    *sum = dot(*sum, x, y);
                }
            }
        }
        for (r, sums) in sums.iter().enumerate().take(rows) {
            for (c, sum) in sums.iter().enumerate() {
                // SAFETY: as for the loads above.
                unsafe {
                    _mm512_mask_storeu_ps(out.as_mut_ptr().add(r * step + c * LANES), mask_of(c), *sum);
                };
            }
        }
    }
}

/// `sum` plus the products of the pairs of `x` and `y`.
#[inline]
#[target_feature(enable = "avx512f,avx512bf16")]
fn dot(sum: __m512, x: __m512i, y: __m512i) -> __m512 {
    // SAFETY: vectors of 512 bits, and any bits are 32 bfloat16 numbers.
    let [x, y] = unsafe { transmute::<[__m512i; 2], [__m512bh; 2]>([x, y]) };
    _mm512_dpbf16_ps(sum, x, y)
}

/// See [`super::Kernel::pack_row`].
pub(super) fn pack_row(row: &[f32], words: &mut [u32]) {
    // SAFETY: a `Kernel` of this kind exists only where `available()` was true.
    unsafe { pack_row_here(row, words) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn pack_row_here(row: &[f32], words: &mut [u32]) {
    for (k, words) in words.chunks_exact_mut(LANES).enumerate() {
        store(words, pairs_of(part(row, 2 * LANES * k, 2 * LANES)));
    }
}

/// Elements `first..first + count` of a slice, as far as it has them.
#[inline]
fn part(row: &[f32], first: usize, count: usize) -> &[f32] {
    let first = first.min(row.len());
    &row[first..row.len().min(first + count)]
}

/// Up to 32 numbers as 16 pairs, zeros beyond the end.
#[inline]
#[target_feature(enable = "avx512f,avx512bf16")]
fn pairs_of(numbers: &[f32]) -> __m512i {
    let (low, high) = numbers.split_at(numbers.len().min(LANES));
    let both = _mm512_cvtne2ps_pbh(load(high), load(low));
    // SAFETY: vectors of 512 bits.
    unsafe { transmute::<__m512bh, __m512i>(both) }
}

/// Up to 16 numbers, zeros beyond the end.
#[inline]
#[target_feature(enable = "avx512f")]
fn load(numbers: &[f32]) -> __m512 {
    // SAFETY: the mask lets no lane beyond the slice through.
    unsafe { _mm512_maskz_loadu_ps(mask(numbers.len()), numbers.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn store(words: &mut [u32], value: __m512i) {
    let words = &mut words[..LANES];
    // SAFETY: 16 words.
    unsafe { _mm512_storeu_si512(words.as_mut_ptr().cast(), value) };
}

/// See [`super::Kernel::pack_panels`]: `source` has its rows side by side. Row by row, because they may come from memory.
pub(super) fn pack_panels(source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
    // SAFETY: a `Kernel` of this kind exists only where `available()` was true.
    unsafe { pack_panels_here(source, size, panels) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn pack_panels_here(source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
    // Number 2 i of a word row is number i of the first vector, number 2 i + 1 that of the second.
    let order: [u16; 2 * LANES] = core::array::from_fn(|i| (i / 2 + LANES * (i % 2)) as u16);
    // SAFETY: 32 numbers of 16 bits.
    let order = unsafe { _mm512_loadu_si512(order.as_ptr().cast()) };
    for p in 0..size / PANEL {
        let row = |r: usize| if r < source.rows() { source.row(r) } else { &[] };
        let (even, odd) = (row(2 * p), row(2 * p + 1));
        let ahead = [row(2 * p + AHEAD), row(2 * p + 1 + AHEAD)];
        for (k, panel) in panels.chunks_exact_mut(size).enumerate() {
            let words = &mut panel[p * PANEL..(p + 1) * PANEL];
            for lane in (0..PANEL).step_by(LANES) {
                let first = k * PANEL + lane;
                for row in ahead {
                    if let Some(x) = row.get(first) {
                        _mm_prefetch::<_MM_HINT_T0>(core::ptr::from_ref(x).cast());
                    }
                }
                let numbers = |row: &[f32]| match row.get(first..first + LANES) {
                    Some(whole) => load(whole),
                    None => load(part(row, first, LANES)),
                };
                // SAFETY: vectors of 512 bits.
                let both = unsafe {
                    transmute::<__m512bh, __m512i>(_mm512_cvtne2ps_pbh(numbers(odd), numbers(even)))
                };
                store(&mut words[lane..], _mm512_permutexvar_epi16(order, both));
            }
        }
    }
}

/// See [`super::Kernel::pack_panels`]: `source` is the transpose, `[cols, inner]`, with its rows side by side.
pub(super) fn pack_panels_of_transpose(source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
    // SAFETY: a `Kernel` of this kind exists only where `available()` was true.
    unsafe { pack_panels_of_transpose_here(source, size, panels) }
}

#[target_feature(enable = "avx512f,avx512bw,avx512bf16")]
fn pack_panels_of_transpose_here(source: Mat<'_, f32>, size: usize, panels: &mut [u32]) {
    for (n, panel) in panels.chunks_exact_mut(size).enumerate() {
        for lane in (0..PANEL).step_by(LANES) {
            let first = n * PANEL + lane;
            for (k, rows) in panel.chunks_exact_mut(LANES * PANEL).enumerate() {
                let mut block = [_mm512_setzero_si512(); LANES];
                for (r, pairs) in block.iter_mut().enumerate() {
                    if first + r < source.rows() {
                        *pairs = pairs_of(part(source.row(first + r), 2 * LANES * k, 2 * LANES));
                    }
                }
                for (p, words) in transposed(block).into_iter().enumerate() {
                    store(&mut rows[p * PANEL + lane..], words);
                }
            }
        }
    }
}

/// Rows of words to columns: in three steps over 32, 64 and 128 bits.
#[inline]
#[target_feature(enable = "avx512f")]
fn transposed(rows: [__m512i; 16]) -> [__m512i; 16] {
    let mut words = rows;
    for k in (0..16).step_by(2) {
        words[k] = _mm512_unpacklo_epi32(rows[k], rows[k + 1]);
        words[k + 1] = _mm512_unpackhi_epi32(rows[k], rows[k + 1]);
    }
    // Number `4 g + c`: in its 128-bit part L, column 4 L + c of rows 4 g to 4 g + 3.
    let mut fours = words;
    for g in (0..16).step_by(4) {
        fours[g] = _mm512_unpacklo_epi64(words[g], words[g + 2]);
        fours[g + 1] = _mm512_unpackhi_epi64(words[g], words[g + 2]);
        fours[g + 2] = _mm512_unpacklo_epi64(words[g + 1], words[g + 3]);
        fours[g + 3] = _mm512_unpackhi_epi64(words[g + 1], words[g + 3]);
    }
    let mut columns = fours;
    for c in 0..4 {
        let [a, b, c_, d] = [fours[c], fours[4 + c], fours[8 + c], fours[12 + c]];
        let even = [_mm512_shuffle_i32x4::<0x88>(a, b), _mm512_shuffle_i32x4::<0x88>(c_, d)];
        let odd = [_mm512_shuffle_i32x4::<0xDD>(a, b), _mm512_shuffle_i32x4::<0xDD>(c_, d)];
        columns[c] = _mm512_shuffle_i32x4::<0x88>(even[0], even[1]);
        columns[4 + c] = _mm512_shuffle_i32x4::<0x88>(odd[0], odd[1]);
        columns[8 + c] = _mm512_shuffle_i32x4::<0xDD>(even[0], even[1]);
        columns[12 + c] = _mm512_shuffle_i32x4::<0xDD>(odd[0], odd[1]);
    }
    columns
}
