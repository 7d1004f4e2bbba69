//! Strided matrix views and their product on the `gemm` crate.

use crate::element::Element;

/// A read-only view of a matrix.
#[derive(Clone, Copy, Debug)]
pub struct Mat<'a, S> {
    data: &'a [S],
    rows: usize,
    cols: usize,
    row_stride: usize,
    col_stride: usize,
}

/// A writable view of a matrix.
#[derive(Debug)]
pub struct MatMut<'a, S> {
    data: &'a mut [S],
    rows: usize,
    cols: usize,
    stride: usize,
}

/// Elements that a `rows` x `cols` view spans.
fn span(rows: usize, cols: usize, row_stride: usize, col_stride: usize) -> usize {
    if rows == 0 || cols == 0 { 0 } else { (rows - 1) * row_stride + (cols - 1) * col_stride + 1 }
}

impl<'a, S: Element> Mat<'a, S> {
    /// A row-major `[rows, cols]` matrix whose rows are `stride` apart.
    ///
    /// # Panics
    /// If `data` is too short.
    pub fn new(data: &'a [S], rows: usize, cols: usize, stride: usize) -> Self {
        assert!(
            data.len() >= span(rows, cols, stride, 1),
            "{} elements are too few for {rows} x {cols}, stride {stride}",
            data.len()
        );
        Self { data, rows, cols, row_stride: stride, col_stride: 1 }
    }

    /// The transpose.
    pub fn t(self) -> Self {
        Self {
            rows: self.cols,
            cols: self.rows,
            row_stride: self.col_stride,
            col_stride: self.row_stride,
            ..self
        }
    }

    /// The same matrix, if its elements are `f32`.
    pub(crate) fn f32(self) -> Option<Mat<'a, f32>> {
        let Self { rows, cols, row_stride, col_stride, .. } = self;
        S::f32s(self.data).map(|data| Mat { data, rows, cols, row_stride, col_stride })
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Columns `first..first + count` of a matrix that was not transposed.
    ///
    /// # Panics
    /// If there are fewer columns.
    pub fn columns(self, first: usize, count: usize) -> Self {
        assert!(self.col_stride == 1 && first + count <= self.cols, "columns out of range");
        Self { data: &self.data[first.min(self.data.len())..], cols: count, ..self }
    }

    /// Rows `first..first + count` of a matrix that was not transposed.
    ///
    /// # Panics
    /// If there are fewer rows.
    pub fn rows_from(self, first: usize, count: usize) -> Self {
        assert!(self.col_stride == 1 && first + count <= self.rows, "rows out of range");
        let start = (first * self.row_stride).min(self.data.len());
        Self { data: &self.data[start..], rows: count, ..self }
    }

    /// Element (`r`, `c`).
    #[inline(always)]
    pub fn get(&self, r: usize, c: usize) -> S {
        self.data[r * self.row_stride + c * self.col_stride]
    }

    /// Row `r`, if its elements lie side by side.
    #[inline(always)]
    pub(crate) fn contiguous_row(&self, r: usize) -> Option<&'a [S]> {
        (self.col_stride == 1 && r < self.rows).then(|| self.row(r))
    }

    /// Row `r` of a matrix that was not transposed.
    #[inline(always)]
    pub fn row(&self, r: usize) -> &'a [S] {
        &self.data[r * self.row_stride..r * self.row_stride + self.cols]
    }
}

impl<'a, S: Element> MatMut<'a, S> {
    /// A row-major `[rows, cols]` matrix whose rows are `stride` apart.
    ///
    /// # Panics
    /// If `data` is too short or rows overlap.
    pub fn new(data: &'a mut [S], rows: usize, cols: usize, stride: usize) -> Self {
        assert!(stride >= cols || rows <= 1, "rows overlap");
        assert!(
            data.len() >= span(rows, cols, stride, 1),
            "{} elements are too few for {rows} x {cols}, stride {stride}",
            data.len()
        );
        Self { data, rows, cols, stride }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn cols(&self) -> usize {
        self.cols
    }

    /// Columns `first..first + count`.
    ///
    /// # Panics
    /// If there are fewer columns.
    pub fn columns(&mut self, first: usize, count: usize) -> MatMut<'_, S> {
        assert!(first + count <= self.cols, "columns out of range");
        let start = first.min(self.data.len());
        MatMut { data: &mut self.data[start..], rows: self.rows, cols: count, stride: self.stride }
    }

    /// The elements from (`row`, `col`) to the last of the block `[rows, cols]` there, and how far its rows are apart.
    ///
    /// # Panics
    /// If the block is empty or reaches beyond the matrix.
    pub(crate) fn block(&mut self, row: usize, rows: usize, col: usize, cols: usize) -> (&mut [S], usize) {
        assert!(
            rows > 0 && cols > 0 && row + rows <= self.rows && col + cols <= self.cols,
            "block out of range"
        );
        let first = row * self.stride + col;
        (&mut self.data[first..first + (rows - 1) * self.stride + cols], self.stride)
    }

    /// The same matrix for a shorter time, if its elements are `f32`.
    pub(crate) fn f32_mut(&mut self) -> Option<MatMut<'_, f32>> {
        let (rows, cols, stride) = (self.rows, self.cols, self.stride);
        S::f32s_mut(self.data).map(|data| MatMut { data, rows, cols, stride })
    }

    /// The same matrix for a shorter time.
    pub fn reborrow(&mut self) -> MatMut<'_, S> {
        MatMut { data: self.data, rows: self.rows, cols: self.cols, stride: self.stride }
    }

    /// The same matrix, read-only.
    pub fn as_ref(&self) -> Mat<'_, S> {
        Mat { data: self.data, rows: self.rows, cols: self.cols, row_stride: self.stride, col_stride: 1 }
    }

    /// Row `r`.
    #[inline(always)]
    pub fn row(&mut self, r: usize) -> &mut [S] {
        &mut self.data[r * self.stride..r * self.stride + self.cols]
    }
}

/// `dst = a b`, or `dst += a b` if `accumulate`. Runs on this thread; equal shapes and strides give equal bits.
///
/// # Panics
/// If the shapes do not fit.
pub fn multiply<S: Element>(dst: MatMut<'_, S>, a: Mat<'_, S>, b: Mat<'_, S>, accumulate: bool) {
    assert!(
        dst.rows == a.rows && dst.cols == b.cols && a.cols == b.rows,
        "[{}, {}] = [{}, {}] [{}, {}] does not fit",
        dst.rows,
        dst.cols,
        a.rows,
        a.cols,
        b.rows,
        b.cols
    );
    S::product(dst, a, b, accumulate);
}

/// [`multiply`] by the `gemm` kernels.
pub(crate) fn product_f32(dst: MatMut<'_, f32>, a: Mat<'_, f32>, b: Mat<'_, f32>, accumulate: bool) {
    // Its kernels prefer a destination whose columns are contiguous: `(a b)^T = b^T a^T`.
    let stride = dst.stride as isize;
    let (dst_col, dst_row, a, b) = if stride > 1 { (stride, 1, b.t(), a.t()) } else { (1, stride, a, b) };
    // SAFETY: every constructor checked that its slice holds each element that rows, columns and strides reach
    // (strides are non-negative); `dst` is a unique borrow, so it overlaps neither operand, and its rows do not
    // overlap.
    #[allow(unsafe_code)]
    unsafe {
        gemm_f32::gemm::f32::get_gemm_fn()(
            a.rows,
            b.cols,
            a.cols,
            dst.data.as_mut_ptr(),
            dst_col,
            dst_row,
            accumulate,
            a.data.as_ptr(),
            a.col_stride as isize,
            a.row_stride as isize,
            b.data.as_ptr(),
            b.col_stride as isize,
            b.row_stride as isize,
            1.0,
            1.0,
            false,
            false,
            false,
            gemm_common::Parallelism::None,
        );
    }
}

/// [`multiply`] in plain loops.
pub(crate) fn product_f64(mut dst: MatMut<'_, f64>, a: Mat<'_, f64>, b: Mat<'_, f64>, accumulate: bool) {
    for i in 0..dst.rows {
        let row = dst.row(i);
        if !accumulate {
            row.fill(0.0);
        }
        for l in 0..a.cols {
            let factor = a.data[i * a.row_stride + l * a.col_stride];
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += factor * b.data[l * b.row_stride + j * b.col_stride];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_product_of_strided_views_matches_the_sum() {
        let (m, n, k) = (5, 7, 3);
        let a: Vec<f64> = (0..m * 4).map(|i| (i as f64 * 0.7).sin()).collect();
        let b: Vec<f64> = (0..n * 9).map(|i| (i as f64 * 0.3).cos()).collect();
        let mut c = vec![1.0; m * 8];
        multiply(MatMut::new(&mut c, m, n, 8), Mat::new(&a, m, k, 4), Mat::new(&b, n, k, 9).t(), true);
        for i in 0..m {
            for j in 0..n {
                let want: f64 = 1.0 + (0..k).map(|l| a[i * 4 + l] * b[j * 9 + l]).sum::<f64>();
                assert!((c[i * 8 + j] - want).abs() < 1e-12);
            }
            assert_eq!(c[i * 8 + 7], 1.0, "padding stays");
        }
    }

    #[test]
    #[should_panic(expected = "too few")]
    fn a_view_beyond_its_slice_is_refused() {
        let _ = Mat::new(&[0.0f32; 5], 2, 3, 3);
    }
}
