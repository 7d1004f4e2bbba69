//! A plane through a few points.

use nalgebra::{Matrix3, Vector3};

/// Points with `normal . p + offset = 0`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: Vector3<f64>,
    /// Minus the distance from the origin along the normal `[m]`.
    pub offset: f64,
}

impl Plane {
    /// The plane with the least sum of squared distances to `points`. `None` if a point is farther from it than `thickness_m`, or if
    /// the points lie on a line, so that they do not determine how the plane is turned about it.
    #[must_use]
    pub fn fit(points: &[Vector3<f64>], thickness_m: f64) -> Option<Self> {
        let mean = points.iter().sum::<Vector3<f64>>() / points.len() as f64;
        let mut scatter = Matrix3::zeros();
        for point in points {
            let d = point - mean;
            scatter.ger(1.0, &d, &d, 1.0);
        }
        let normal = flattest_direction(&scatter)?;
        let plane = Self { normal, offset: -normal.dot(&mean) };
        points.iter().all(|p| plane.distance(p).abs() <= thickness_m).then_some(plane)
    }

    /// Signed distance of `p` `[m]`.
    #[must_use]
    pub fn distance(&self, p: &Vector3<f64>) -> f64 {
        self.normal.dot(p) + self.offset
    }
}

/// The unit eigenvector of the smallest eigenvalue of a symmetric matrix, by the cubic's closed form. `None` if the two smaller
/// eigenvalues are both far below the largest (points on a line).
fn flattest_direction(a: &Matrix3<f64>) -> Option<Vector3<f64>> {
    let mean = a.trace() / 3.0;
    let b = a - Matrix3::identity() * mean;
    let p = (b.norm_squared() / 6.0).sqrt();
    if p.partial_cmp(&1e-12) != Some(core::cmp::Ordering::Greater) {
        return None;
    }
    let r = (b.determinant() / (2.0 * p.powi(3))).clamp(-1.0, 1.0);
    let third = r.acos() / 3.0;
    let largest = mean + 2.0 * p * third.cos();
    let smallest = mean + 2.0 * p * (third + core::f64::consts::TAU / 3.0).cos();
    let middle = 3.0 * mean - largest - smallest;
    if middle < 0.01 * largest {
        return None;
    }
    // Rows of A - smallest I span the plane across the wanted vector.
    let m = a - Matrix3::identity() * smallest;
    let rows: [Vector3<f64>; 3] = [m.row(0).transpose(), m.row(1).transpose(), m.row(2).transpose()];
    let crosses = [rows[0].cross(&rows[1]), rows[1].cross(&rows[2]), rows[2].cross(&rows[0])];
    let longest = crosses.iter().max_by(|a, b| a.norm_squared().total_cmp(&b.norm_squared()))?;
    longest.try_normalize(1e-30)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn five_points_of_a_tilted_plane_give_its_normal() {
        // z = x + 1, whose normal is (-1, 0, 1) / sqrt 2.
        let points = [[0.0, 0.0], [1.0, 0.2], [0.4, 1.0], [0.9, 0.8], [0.1, 0.7]]
            .map(|[x, y]| Vector3::new(x, y, x + 1.0));
        let plane = Plane::fit(&points, 0.1).expect("flat");
        let normal = Vector3::new(-1.0, 0.0, 1.0).normalize();
        assert!((plane.normal.dot(&normal).abs() - 1.0).abs() < 1e-9, "{plane:?}");
        assert!((plane.distance(&Vector3::new(0.0, 0.0, 2.0)).abs() - 0.5_f64.sqrt()).abs() < 1e-9);
    }

    #[test]
    fn a_point_0_2_m_off_spoils_the_plane() {
        let mut points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0], [0.5, 0.5]]
            .map(|[x, y]| Vector3::new(x, y, 0.0));
        assert!(Plane::fit(&points, 0.1).is_some());
        points[4].z = 0.2;
        assert!(Plane::fit(&points, 0.1).is_none());
    }

    #[test]
    fn points_on_a_line_or_in_one_place_have_no_plane() {
        let line = [0.0, 0.3, 0.5, 0.8, 1.0].map(|z| Vector3::new(2.0, 1.0, z));
        assert!(Plane::fit(&line, 0.1).is_none());
        assert!(Plane::fit(&[Vector3::x(); 5], 0.1).is_none());
    }

    proptest! {
        #[test]
        fn the_direction_is_that_of_nalgebras_eigenvectors(v in proptest::collection::vec(-1.0..1.0_f64, 15)) {
            let points: Vec<Vector3<f64>> = v.chunks(3).map(|c| Vector3::new(c[0], c[1], 0.2 * c[2])).collect();
            let mean = points.iter().sum::<Vector3<f64>>() / 5.0;
            let scatter: Matrix3<f64> = points.iter().map(|p| (p - mean) * (p - mean).transpose()).sum();
            let eigen = scatter.symmetric_eigen();
            let mut sorted = eigen.eigenvalues;
            sorted.as_mut_slice().sort_by(f64::total_cmp);
            prop_assume!(sorted[1] > 2.0 * sorted[0] && sorted[1] > 0.02 * sorted[2]);
            let direction = flattest_direction(&scatter).expect("a plane");
            let expected = eigen.eigenvectors.column(eigen.eigenvalues.imin());
            prop_assert!((direction.dot(&expected).abs() - 1.0).abs() < 1e-6);
        }
    }
}
