//! Gravity: a vector of known length and unknown direction, so a point on a sphere with two degrees of freedom.
//!
//! Source: He, Xu, Zhang, *Kalman Filters on Differentiable Manifolds*, 2021, the sphere S^2(r).

use nalgebra::{Matrix2, Matrix3x2, Vector2, Vector3};

use crate::so3::{exp, left_jacobian, skew};

/// Standard length of gravity `[m/s^2]`.
pub const GRAVITY: f64 = 9.81;

/// Gravity in the odometry frame, of length [`GRAVITY`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gravity(Vector3<f64>);

impl Gravity {
    /// Gravity along `direction`; straight down if `direction` has no length.
    #[must_use]
    pub fn along(direction: &Vector3<f64>) -> Self {
        Self(direction.try_normalize(1e-12).unwrap_or(-Vector3::z()) * GRAVITY)
    }

    /// The vector `[m/s^2]`.
    #[must_use]
    pub fn vector(&self) -> Vector3<f64> {
        self.0
    }

    /// Two orthonormal columns across the vector: the axes of the tangent plane.
    #[must_use]
    pub fn basis(&self) -> Matrix3x2<f64> {
        let g = self.0 / GRAVITY;
        // The coordinate axis most across the vector, so that the cross product is long.
        let axis = Vector3::ith(g.iamin(), 1.0);
        let a = g.cross(&axis).normalize();
        Matrix3x2::from_columns(&[a, g.cross(&a)])
    }

    /// Turned by the tangent vector `d` `[rad]`.
    #[must_use]
    pub fn plus(&self, d: &Vector2<f64>) -> Self {
        Self::along(&(exp(&(self.basis() * d)) * self.0))
    }

    /// The tangent vector `[rad]` that leads from `other` to `self`: `other.plus(&self.minus(&other)) = self`.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Vector2<f64> {
        let c = other.0.cross(&self.0);
        let sine = c.norm();
        let cosine = other.0.dot(&self.0);
        if sine < 1e-12 {
            // Equal, or opposite: then any axis leads there.
            return if cosine >= 0.0 { Vector2::zeros() } else { Vector2::new(core::f64::consts::PI, 0.0) };
        }
        other.basis().transpose() * c * (sine.atan2(cosine) / sine)
    }

    /// Derivative of the vector by the tangent vector at zero: columns `[m/s^2/rad]`.
    #[must_use]
    pub fn vector_jacobian(&self) -> Matrix3x2<f64> {
        -skew(&self.0) * self.basis()
    }

    /// Derivative of `self.plus(d).minus(other)` by `d` at zero.
    #[must_use]
    pub fn minus_jacobian(&self, other: &Self) -> Matrix2<f64> {
        let (x, y) = (other.0, self.0);
        let c = x.cross(&y);
        let sine = c.norm();
        let cosine = x.dot(&y);
        let dy = self.vector_jacobian();
        let dc = skew(&x) * dy;
        let g4 = GRAVITY.powi(4);
        if sine < 1e-9 {
            return other.basis().transpose() * dc / (GRAVITY * GRAVITY);
        }
        let angle = sine.atan2(cosine);
        let dsine = c.transpose() * dc / sine;
        let dcosine = x.transpose() * dy;
        let dangle = (dsine * cosine - dcosine * sine) / g4;
        let d = dc * (angle / sine) + c * (dangle / sine - dsine * (angle / (sine * sine)));
        other.basis().transpose() * d
    }

    /// Derivative of `self.plus(d + e).minus(&self.plus(d))` by `e` at zero: carries a covariance over an update by `d`.
    #[must_use]
    pub fn reset_jacobian(&self, d: &Vector2<f64>) -> Matrix2<f64> {
        let turn = self.basis() * d;
        self.plus(d).basis().transpose() * left_jacobian(&turn) * self.basis()
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn direction() -> impl Strategy<Value = Vector3<f64>> {
        (-1.0..1.0_f64, -1.0..1.0_f64, -1.0..1.0_f64)
            .prop_map(|(x, y, z)| Vector3::new(x, y, z))
            .prop_filter("has a length", |v| v.norm() > 0.1)
    }

    proptest! {
        #[test]
        fn minus_is_the_inverse_of_plus(from in direction(), a in -1.5..1.5_f64, b in -1.5..1.5_f64) {
            let from = Gravity::along(&from);
            let d = Vector2::new(a, b);
            let to = from.plus(&d);
            prop_assert!((to.vector().norm() - GRAVITY).abs() < 1e-9);
            prop_assert!((to.minus(&from) - d).norm() < 1e-9);
        }

        #[test]
        fn jacobians_match_finite_differences(from in direction(), a in -1.0..1.0_f64, b in -1.0..1.0_f64) {
            let from = Gravity::along(&from);
            let d = Vector2::new(a, b);
            let to = from.plus(&d);
            let h = 1e-6;
            for i in 0..2 {
                let mut e = Vector2::zeros();
                e[i] = h;
                let minus = (to.plus(&e).minus(&from) - to.plus(&-e).minus(&from)) / (2.0 * h);
                prop_assert!((minus - to.minus_jacobian(&from).column(i)).norm() < 1e-6);
                let reset = (from.plus(&(d + e)).minus(&to) - from.plus(&(d - e)).minus(&to)) / (2.0 * h);
                prop_assert!((reset - from.reset_jacobian(&d).column(i)).norm() < 1e-6);
                let vector = (to.plus(&e).vector() - to.plus(&-e).vector()) / (2.0 * h);
                prop_assert!((vector - to.vector_jacobian().column(i)).norm() < 1e-6);
            }
        }
    }

    #[test]
    fn a_quarter_turn_of_gravity_is_a_tangent_vector_of_that_length() {
        let down = Gravity::along(&-Vector3::z());
        let side = Gravity::along(&Vector3::x());
        assert!((side.minus(&down).norm() - core::f64::consts::FRAC_PI_2).abs() < 1e-12);
    }
}
