//! Rotations as vectors: exponential, logarithm and their Jacobians on SO(3).
//!
//! Formulas: Barfoot, *State Estimation for Robotics*, chapter 7; Forster and others, *On-Manifold Preintegration*, 2017.

use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Below this angle `[rad]` series replace the closed forms.
const SMALL: f64 = 1e-5;

/// The matrix `[v]x` with `[v]x w = v x w`.
#[must_use]
pub fn skew(v: &Vector3<f64>) -> Matrix3<f64> {
    Matrix3::new(0.0, -v.z, v.y, v.z, 0.0, -v.x, -v.y, v.x, 0.0)
}

/// The rotation by angle `|v|` `[rad]` about `v`.
#[must_use]
pub fn exp(v: &Vector3<f64>) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(*v)
}

/// The rotation vector of `q` `[rad]`, of length at most pi.
#[must_use]
pub fn log(q: &UnitQuaternion<f64>) -> Vector3<f64> {
    q.scaled_axis()
}

/// Right Jacobian: `exp(v + d) = exp(v) exp(J d)` to first order in `d`.
#[must_use]
pub fn right_jacobian(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = skew(v);
    let (a, b) = if angle < SMALL {
        (0.5, 1.0 / 6.0)
    } else {
        ((1.0 - angle.cos()) / (angle * angle), (angle - angle.sin()) / angle.powi(3))
    };
    Matrix3::identity() - k * a + k * k * b
}

/// Left Jacobian: `exp(v + d) = exp(J d) exp(v)` to first order in `d`.
#[must_use]
pub fn left_jacobian(v: &Vector3<f64>) -> Matrix3<f64> {
    right_jacobian(&-v)
}

/// Inverse of the right Jacobian: `log(exp(v) exp(d)) = v + J^-1 d` to first order in `d`.
#[must_use]
pub fn right_jacobian_inverse(v: &Vector3<f64>) -> Matrix3<f64> {
    let angle = v.norm();
    let k = skew(v);
    let b = if angle < SMALL {
        1.0 / 12.0
    } else {
        1.0 / (angle * angle) - (1.0 + angle.cos()) / (2.0 * angle * angle.sin())
    };
    Matrix3::identity() + k * 0.5 + k * k * b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_exponential_of_a_right_angle_about_z_turns_x_to_y() {
        let y = exp(&Vector3::new(0.0, 0.0, core::f64::consts::FRAC_PI_2)) * Vector3::x();
        assert!((y - Vector3::y()).norm() < 1e-15, "{y}");
    }

    #[test]
    fn jacobians_match_finite_differences() {
        let h = 1e-6;
        for v in [Vector3::new(0.3, -0.8, 1.1), Vector3::new(1e-7, 2e-7, -1e-7)] {
            for i in 0..3 {
                let mut d = Vector3::zeros();
                d[i] = h;
                let right = log(&(exp(&v).inverse() * exp(&(v + d)))) / h;
                assert!((right - right_jacobian(&v).column(i)).norm() < 2e-6);
                let left = log(&(exp(&(v + d)) * exp(&v).inverse())) / h;
                assert!((left - left_jacobian(&v).column(i)).norm() < 2e-6);
                let inverse = (log(&(exp(&v) * exp(&d))) - v) / h;
                assert!((inverse - right_jacobian_inverse(&v).column(i)).norm() < 2e-6);
            }
        }
    }
}
