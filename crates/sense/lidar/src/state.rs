//! The state of the filter, a point on a manifold of 23 degrees of freedom.

use nalgebra::{Isometry3, SMatrix, SVector, Translation3, UnitQuaternion, Vector2, Vector3};

use crate::gravity::Gravity;
use crate::so3::{exp, log, right_jacobian, right_jacobian_inverse};

/// Degrees of freedom.
pub const DOF: usize = 23;
/// Where each part begins in a tangent vector.
pub const POSITION: usize = 0;
/// Rotation of the IMU.
pub const ROTATION: usize = 3;
/// Rotation of the LiDAR against the IMU.
pub const LIDAR_ROTATION: usize = 6;
/// Position of the LiDAR against the IMU.
pub const LIDAR_POSITION: usize = 9;
/// Velocity of the IMU.
pub const VELOCITY: usize = 12;
/// Bias of the gyroscope.
pub const GYRO_BIAS: usize = 15;
/// Bias of the accelerometer.
pub const ACCEL_BIAS: usize = 18;
/// Direction of gravity.
pub const GRAVITY_DIRECTION: usize = 21;

/// A small change of a state, in the order of the constants above.
pub type Tangent = SVector<f64, DOF>;
/// Covariance of a [`Tangent`].
pub type Covariance = SMatrix<f64, DOF, DOF>;

/// What the filter estimates. Frame "odometry": z up, origin and heading those of the IMU when it was started.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Position of the IMU in the odometry frame `[m]`.
    pub position: Vector3<f64>,
    /// Rotation from the IMU frame to the odometry frame.
    pub rotation: UnitQuaternion<f64>,
    /// Rotation from the LiDAR frame to the IMU frame.
    pub lidar_rotation: UnitQuaternion<f64>,
    /// Origin of the LiDAR in the IMU frame `[m]`.
    pub lidar_position: Vector3<f64>,
    /// Velocity of the IMU in the odometry frame `[m/s]`.
    pub velocity: Vector3<f64>,
    /// What the gyroscope shows at rest `[rad/s]`.
    pub gyro_bias: Vector3<f64>,
    /// What the accelerometer shows too much `[m/s^2]`.
    pub accel_bias: Vector3<f64>,
    /// Gravity in the odometry frame.
    pub gravity: Gravity,
}

impl Default for State {
    fn default() -> Self {
        Self {
            position: Vector3::zeros(),
            rotation: UnitQuaternion::identity(),
            lidar_rotation: UnitQuaternion::identity(),
            lidar_position: Vector3::zeros(),
            velocity: Vector3::zeros(),
            gyro_bias: Vector3::zeros(),
            accel_bias: Vector3::zeros(),
            gravity: Gravity::along(&-Vector3::z()),
        }
    }
}

impl State {
    /// The state changed by `d`: rotations by a turn in their own (right) frame, the sphere along it, the rest by a sum.
    #[must_use]
    pub fn plus(&self, d: &Tangent) -> Self {
        let part = |at: usize| -> Vector3<f64> { d.fixed_rows::<3>(at).into() };
        let gravity: Vector2<f64> = d.fixed_rows::<2>(GRAVITY_DIRECTION).into();
        let turned = |q: &UnitQuaternion<f64>, at| {
            let mut turned = q * exp(&part(at));
            turned.renormalize();
            turned
        };
        Self {
            position: self.position + part(POSITION),
            rotation: turned(&self.rotation, ROTATION),
            lidar_rotation: turned(&self.lidar_rotation, LIDAR_ROTATION),
            lidar_position: self.lidar_position + part(LIDAR_POSITION),
            velocity: self.velocity + part(VELOCITY),
            gyro_bias: self.gyro_bias + part(GYRO_BIAS),
            accel_bias: self.accel_bias + part(ACCEL_BIAS),
            gravity: self.gravity.plus(&gravity),
        }
    }

    /// The tangent vector that leads from `other` to `self`.
    #[must_use]
    pub fn minus(&self, other: &Self) -> Tangent {
        let mut d = Tangent::zeros();
        let mut set = |at: usize, v: Vector3<f64>| d.fixed_rows_mut::<3>(at).copy_from(&v);
        set(POSITION, self.position - other.position);
        set(ROTATION, log(&(other.rotation.inverse() * self.rotation)));
        set(LIDAR_ROTATION, log(&(other.lidar_rotation.inverse() * self.lidar_rotation)));
        set(LIDAR_POSITION, self.lidar_position - other.lidar_position);
        set(VELOCITY, self.velocity - other.velocity);
        set(GYRO_BIAS, self.gyro_bias - other.gyro_bias);
        set(ACCEL_BIAS, self.accel_bias - other.accel_bias);
        d.fixed_rows_mut::<2>(GRAVITY_DIRECTION).copy_from(&self.gravity.minus(&other.gravity));
        d
    }

    /// Derivative of `self.plus(d).minus(other)` by `d` at zero.
    #[must_use]
    pub fn minus_jacobian(&self, other: &Self) -> Covariance {
        let d = self.minus(other);
        let mut jacobian = Covariance::identity();
        for at in [ROTATION, LIDAR_ROTATION] {
            let turn: Vector3<f64> = d.fixed_rows::<3>(at).into();
            jacobian.fixed_view_mut::<3, 3>(at, at).copy_from(&right_jacobian_inverse(&turn));
        }
        jacobian
            .fixed_view_mut::<2, 2>(GRAVITY_DIRECTION, GRAVITY_DIRECTION)
            .copy_from(&self.gravity.minus_jacobian(&other.gravity));
        jacobian
    }

    /// Derivative of `self.plus(d + e).minus(&self.plus(d))` by `e` at zero: carries a covariance over an update by `d`.
    #[must_use]
    pub fn reset_jacobian(&self, d: &Tangent) -> Covariance {
        let mut jacobian = Covariance::identity();
        for at in [ROTATION, LIDAR_ROTATION] {
            let turn: Vector3<f64> = d.fixed_rows::<3>(at).into();
            jacobian.fixed_view_mut::<3, 3>(at, at).copy_from(&right_jacobian(&turn));
        }
        let gravity: Vector2<f64> = d.fixed_rows::<2>(GRAVITY_DIRECTION).into();
        jacobian
            .fixed_view_mut::<2, 2>(GRAVITY_DIRECTION, GRAVITY_DIRECTION)
            .copy_from(&self.gravity.reset_jacobian(&gravity));
        jacobian
    }

    /// Pose of the IMU in the odometry frame.
    #[must_use]
    pub fn odometry_from_imu(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.position), self.rotation)
    }

    /// Pose of the LiDAR in the IMU frame.
    #[must_use]
    pub fn imu_from_lidar(&self) -> Isometry3<f64> {
        Isometry3::from_parts(Translation3::from(self.lidar_position), self.lidar_rotation)
    }

    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        let vectors = [self.position, self.lidar_position, self.velocity, self.gyro_bias, self.accel_bias];
        vectors.iter().all(|v| v.iter().all(|x| x.is_finite()))
            && self.gravity.vector().iter().all(|x| x.is_finite())
            && [self.rotation, self.lidar_rotation].iter().all(|q| q.coords.iter().all(|x| x.is_finite()))
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Any tangent vector with turns up to 1 rad an axis.
    pub(crate) fn tangent() -> impl Strategy<Value = Tangent> {
        proptest::collection::vec(-1.0..1.0_f64, DOF).prop_map(|v| Tangent::from_column_slice(&v))
    }

    proptest! {
        #[test]
        fn minus_is_the_inverse_of_plus(start in tangent(), d in tangent()) {
            let from = State::default().plus(&start);
            prop_assert!((from.plus(&d).minus(&from) - d).norm() < 1e-9);
            prop_assert!(from.minus(&from).norm() < 1e-12);
        }

        #[test]
        fn jacobians_match_finite_differences(start in tangent(), d in tangent()) {
            let from = State::default().plus(&start);
            let to = from.plus(&d);
            let h = 1e-6;
            let minus = to.minus_jacobian(&from);
            let reset = from.reset_jacobian(&d);
            for i in 0..DOF {
                let mut e = Tangent::zeros();
                e[i] = h;
                let column = (to.plus(&e).minus(&from) - to.plus(&-e).minus(&from)) / (2.0 * h);
                prop_assert!((column - minus.column(i)).norm() < 1e-6);
                let column = (from.plus(&(d + e)).minus(&to) - from.plus(&(d - e)).minus(&to)) / (2.0 * h);
                prop_assert!((column - reset.column(i)).norm() < 1e-6);
            }
        }
    }
}
