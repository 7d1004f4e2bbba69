//! The sparse normal equations of a motion: a symmetric band, factored in place.

/// One residual's derivatives: pairs of variable and value, variables may repeat.
#[derive(Default)]
pub(super) struct Row(Vec<(usize, f64)>);

impl Row {
    pub fn clear(&mut self) {
        self.0.clear();
    }
    pub fn add(&mut self, variable: usize, value: f64) {
        if value != 0.0 {
            self.0.push((variable, value));
        }
    }
    /// Sums what belongs to the same variable; in order of the variables.
    fn tidy(&mut self) {
        self.0.sort_unstable_by_key(|e| e.0);
        self.0.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
    }
}

/// A symmetric matrix whose elements are zero further than `width - 1` from the diagonal, and a right side. Row `i` holds columns
/// `i + 1 - width ..= i`.
pub(super) struct Band {
    pub size: usize,
    pub width: usize,
    pub lower: Vec<f64>,
    pub right: Vec<f64>,
}

impl Band {
    pub fn new(size: usize, width: usize) -> Self {
        Self { size, width, lower: vec![0.0; size * width], right: vec![0.0; size] }
    }

    pub fn clear(&mut self) {
        self.lower.fill(0.0);
        self.right.fill(0.0);
    }

    /// Adds a residual `r + row . step` of weight `w2` (already squared).
    pub fn add(&mut self, row: &mut Row, r: f64, w2: f64) {
        row.tidy();
        for (a, &(i, x)) in row.0.iter().enumerate() {
            let scaled = w2 * x;
            self.right[i] -= scaled * r;
            let line = &mut self.lower[i * self.width..(i + 1) * self.width];
            for &(j, y) in &row.0[..=a] {
                line[self.width - 1 + j - i] += scaled * y;
            }
        }
    }

    /// Adds to the diagonal: a share of itself and a constant.
    pub fn damp(&mut self, share: f64, least: f64) {
        for i in 0..self.size {
            let d = &mut self.lower[i * self.width + self.width - 1];
            *d += share * *d + least;
        }
    }

    /// The solution by Cholesky's factorization; the matrix is used up. `None` if it is not positive definite.
    pub fn solve(&mut self) -> Option<Vec<f64>> {
        let w = self.width;
        for i in 0..self.size {
            let (above, rest) = self.lower.split_at_mut(i * w);
            let line = &mut rest[..w];
            let first = (i + 1).saturating_sub(w);
            for j in first..i {
                // Columns that both rows have, as slices of the two stored lines.
                let from = first.max((j + 1).saturating_sub(w));
                let other = &above[j * w..(j + 1) * w];
                let (a, b) = (w - 1 + from - i, w - 1 + from - j);
                let sum = dot(&line[a..w - 1 + j - i], &other[b..w - 1]);
                line[w - 1 + j - i] = (line[w - 1 + j - i] - sum) / other[w - 1];
            }
            let own = &line[w - 1 - (i - first)..w - 1];
            let pivot = line[w - 1] - dot(own, own);
            if !(pivot > 0.0 && pivot.is_finite()) {
                return None;
            }
            line[w - 1] = pivot.sqrt();
        }
        let mut x = self.right.clone();
        for i in 0..self.size {
            let first = (i + 1).saturating_sub(w);
            let line = &self.lower[i * w..(i + 1) * w];
            let sum = dot(&line[w - 1 - (i - first)..w - 1], &x[first..i]);
            x[i] = (x[i] - sum) / line[w - 1];
        }
        for i in (0..self.size).rev() {
            let first = (i + 1).saturating_sub(w);
            let line = &self.lower[i * w..(i + 1) * w];
            x[i] /= line[w - 1];
            let value = x[i];
            for (k, l) in (first..i).zip(&line[w - 1 - (i - first)..w - 1]) {
                x[k] -= l * value;
            }
        }
        Some(x)
    }
}

/// Dot product in eight independent sums, so that it is done in vectors.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (mut sums, (ca, cb)) = ([0.0; 8], (a.chunks_exact(8), b.chunks_exact(8)));
    let tail: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for k in 0..8 {
            sums[k] += x[k] * y[k];
        }
    }
    tail + sums.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_band_is_solved_as_by_hand() {
        // 4 -2 0; -2 5 -4; 0 -4 9 times (1, 2, 3) is (0, -4, 19).
        let mut band = Band::new(3, 2);
        band.lower = vec![0.0, 4.0, -2.0, 5.0, -4.0, 9.0];
        band.right = vec![0.0, -4.0, 19.0];
        let x = band.solve().expect("positive definite");
        for (found, expected) in x.iter().zip([1.0, 2.0, 3.0]) {
            assert!((found - expected).abs() < 1e-12, "{x:?}");
        }
        band.lower = vec![0.0, 1.0, 2.0, 1.0, 0.0, 1.0];
        assert!(band.solve().is_none(), "1 2; 2 1 is indefinite");
    }

    #[test]
    fn rows_add_up_to_normal_equations() {
        // Minimize (x + 2 y - 5)^2 + 4 (x - 1)^2 from zero: x = 1, y = 2.
        let mut band = Band::new(2, 2);
        let mut row = Row::default();
        for (variable, value) in [(1, 1.5), (0, 1.0), (1, 0.5)] {
            row.add(variable, value);
        }
        band.add(&mut row, -5.0, 1.0);
        row.clear();
        row.add(0, 1.0);
        band.add(&mut row, -1.0, 4.0);
        let x = band.solve().expect("positive definite");
        assert!((x[0] - 1.0).abs() < 1e-12 && (x[1] - 2.0).abs() < 1e-12, "{x:?}");
    }

    #[test]
    fn a_long_band_leaves_no_remainder() {
        let (n, w) = (60, 21);
        let value = |i: usize, j: usize| if i == j { 50.0 } else { ((i * 7 + j * 3) % 5) as f64 - 2.0 };
        let mut band = Band::new(n, w);
        let mut right = vec![0.0; n];
        for i in 0..n {
            for j in (i + 1).saturating_sub(w)..=i {
                band.lower[i * w + w - 1 + j - i] = value(i, j);
                right[i] += value(i, j) * (j as f64).sin();
                if i != j {
                    right[j] += value(i, j) * (i as f64).sin();
                }
            }
        }
        band.right = right;
        let x = band.solve().expect("diagonally dominant");
        assert!(x.iter().enumerate().all(|(i, x)| (x - (i as f64).sin()).abs() < 1e-10), "{x:?}");
    }
}
