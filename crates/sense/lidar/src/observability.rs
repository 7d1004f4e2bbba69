//! Which directions of motion a scan can see.
//!
//! The translation information matrix is the sum of `n n'` over the normals of all matched planes. In a corridor no normal points
//! along it, so one eigenvalue is nothing but noise (Zhang, Kaess, Singh, *On Degeneracy of Optimization-based State
//! Estimation Problems*, 2016).

use nalgebra::{Matrix3, Vector3};

/// A normal within 60 degrees of a direction constrains motion along it; with more the noise of the normals would count.
const FACING: f64 = 0.5;

/// What one scan sees of translation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observability {
    /// Eigenvalues of the information matrix, smallest first: planes' worth along each direction.
    pub eigenvalues: [f64; 3],
    /// The direction that is seen least, a unit vector in the odometry frame.
    pub weakest: Vector3<f64>,
    /// Sum of squared cosines of the planes that face [`Self::weakest`].
    pub facing: f64,
}

impl Observability {
    /// Of the normals of all matched planes.
    #[must_use]
    pub fn of(normals: &[Vector3<f64>]) -> Self {
        let mut information = Matrix3::zeros();
        for n in normals {
            information.ger(1.0, n, n, 1.0);
        }
        let eigen = information.symmetric_eigen();
        let weakest: Vector3<f64> = eigen.eigenvectors.column(eigen.eigenvalues.imin()).into();
        let mut eigenvalues = [eigen.eigenvalues[0], eigen.eigenvalues[1], eigen.eigenvalues[2]];
        eigenvalues.sort_by(f64::total_cmp);
        let facing =
            normals.iter().map(|n| n.dot(&weakest)).filter(|c| c.abs() > FACING).map(|c| c * c).sum();
        Self { eigenvalues, weakest, facing }
    }

    /// The direction along which motion is not seen, if fewer than `needed` planes face it.
    #[must_use]
    pub fn unobservable(&self, needed: f64) -> Option<Vector3<f64>> {
        (self.facing < needed).then_some(self.weakest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_corridor_along_x_hides_x_even_with_noisy_normals() {
        let normals: Vec<Vector3<f64>> = (0..300)
            .map(|i| {
                let noise = 0.1 * (f64::from(i) * 1.3).sin();
                let n = if i % 2 == 0 { Vector3::y() } else { Vector3::z() };
                (n + Vector3::x() * noise).normalize()
            })
            .collect();
        let found = Observability::of(&normals);
        assert!(found.weakest.x.abs() > 0.99, "{found:?}");
        assert!(found.eigenvalues[0] > 1.0, "noise alone is worth more than one plane: {found:?}");
        assert_eq!(found.facing, 0.0);
        assert!(found.unobservable(5.0).is_some());
    }

    #[test]
    fn ten_planes_at_the_corridors_end_make_it_observable() {
        let mut normals = vec![Vector3::y(); 100];
        normals.extend([Vector3::z(); 100]);
        normals.extend([Vector3::x(); 10]);
        let found = Observability::of(&normals);
        assert!((found.eigenvalues[0] - 10.0).abs() < 1e-9);
        assert!(found.unobservable(5.0).is_none());
    }
}
