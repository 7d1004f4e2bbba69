//! Eigenvalues of small symmetric matrices.

use nalgebra::DMatrix;

/// Eigenvalues and eigenvectors (`vectors[k][i]`: component `k` of the `i`-th vector) of a symmetric matrix.
pub(crate) fn eigen<const N: usize>(matrix: &[[f64; N]; N]) -> ([f64; N], [[f64; N]; N]) {
    let found = DMatrix::from_fn(N, N, |i, j| matrix[i][j]).symmetric_eigen();
    let vectors = std::array::from_fn(|k| std::array::from_fn(|i| found.eigenvectors[(k, i)]));
    (std::array::from_fn(|i| found.eigenvalues[i]), vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_and_values_rebuild_the_matrix() {
        let matrix =
            [[4.0, 1.0, -2.0, 0.0], [1.0, 3.0, 0.5, 0.0], [-2.0, 0.5, 1.0, 0.0], [0.0, 0.0, 0.0, -7.0]];
        let (values, vectors) = eigen(&matrix);
        for i in 0..4 {
            for j in 0..4 {
                let rebuilt: f64 = (0..4).map(|k| vectors[i][k] * values[k] * vectors[j][k]).sum();
                assert!((rebuilt - matrix[i][j]).abs() < 1e-12, "{i} {j}: {rebuilt}");
                let product: f64 = (0..4).map(|k| vectors[k][i] * vectors[k][j]).sum();
                assert!((product - f64::from(u8::from(i == j))).abs() < 1e-12);
            }
        }
    }
}
