//! Prediction of state and covariance from two consecutive IMU samples.
//!
//! Source of the method: Xu, Cai, He, Lin, Zhang, *FAST-LIO2*, 2022, section IV. The mean of two samples holds over the step,
//! turned by half the step's rotation.

use nalgebra::{SMatrix, Vector3};

use crate::imu::ImuSample;
use crate::so3::{exp, right_jacobian, skew};
use crate::state::{
    ACCEL_BIAS, Covariance, DOF, GRAVITY_DIRECTION, GYRO_BIAS, POSITION, ROTATION, State, VELOCITY,
};

/// Variances of the IMU, per sample and axis.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ImuNoise {
    /// Gyroscope `[rad^2/s^2]`.
    pub gyro: f64,
    /// Accelerometer `[m^2/s^4]`.
    pub accel: f64,
    /// Walk of the gyroscope's bias `[rad^2/s^4]`.
    pub gyro_bias: f64,
    /// Walk of the accelerometer's bias `[m^2/s^6]`.
    pub accel_bias: f64,
}

/// Motion of the IMU during one step.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// Length of the step `[s]`.
    pub dt: f64,
    /// Angular velocity without bias, IMU frame `[rad/s]`.
    pub gyro: Vector3<f64>,
    /// Acceleration in the odometry frame, gravity included `[m/s^2]`.
    pub accel: Vector3<f64>,
    /// Specific force without bias, in the IMU frame at the begin of the step `[m/s^2]`.
    force: Vector3<f64>,
    /// Specific force without bias, in the IMU frame at the middle of the step `[m/s^2]`.
    force_at_middle: Vector3<f64>,
}

impl Step {
    /// The step from sample `a` to sample `b`, which begins in `state`.
    #[must_use]
    pub fn new(state: &State, a: &ImuSample, b: &ImuSample) -> Self {
        let dt = b.time_s - a.time_s;
        let gyro = (a.gyro + b.gyro) * 0.5 - state.gyro_bias;
        let force_at_middle = (a.accel + b.accel) * 0.5 - state.accel_bias;
        let force = exp(&(gyro * (0.5 * dt))) * force_at_middle;
        Self { dt, gyro, accel: state.rotation * force + state.gravity.vector(), force, force_at_middle }
    }

    /// The state at the end of the step.
    #[must_use]
    pub fn apply(&self, state: &State) -> State {
        let mut next = state.clone();
        next.position += state.velocity * self.dt + self.accel * (0.5 * self.dt * self.dt);
        next.velocity += self.accel * self.dt;
        next.rotation = state.rotation * exp(&(self.gyro * self.dt));
        next.rotation.renormalize();
        next
    }

    /// Derivative of the next state's tangent by the state's tangent, and by the noise of gyroscope, accelerometer and their biases.
    #[must_use]
    pub fn jacobians(&self, state: &State) -> (Covariance, SMatrix<f64, DOF, 12>) {
        let dt = self.dt;
        let rotation = state.rotation.to_rotation_matrix().into_inner();
        let turn = self.gyro * dt;
        let half = turn * 0.5;
        // By the error of rotation, gyroscope, accelerometer and gravity: acceleration in the odometry frame.
        let by_rotation = -rotation * skew(&self.force);
        let middle = rotation * exp(&half).to_rotation_matrix().into_inner();
        let by_gyro = middle * -skew(&self.force_at_middle) * right_jacobian(&half) * (0.5 * dt);
        let by_gravity = state.gravity.vector_jacobian();

        let mut f = Covariance::identity();
        f.fixed_view_mut::<3, 3>(POSITION, VELOCITY).fill_with_identity();
        f.fixed_view_mut::<3, 3>(POSITION, VELOCITY).scale_mut(dt);
        for (row, weight) in [(POSITION, 0.5 * dt * dt), (VELOCITY, dt)] {
            f.fixed_view_mut::<3, 3>(row, ROTATION).copy_from(&(by_rotation * weight));
            f.fixed_view_mut::<3, 3>(row, GYRO_BIAS).copy_from(&(-by_gyro * weight));
            f.fixed_view_mut::<3, 3>(row, ACCEL_BIAS).copy_from(&(-middle * weight));
            f.fixed_view_mut::<3, 2>(row, GRAVITY_DIRECTION).copy_from(&(by_gravity * weight));
        }
        let turned = exp(&-turn).to_rotation_matrix().into_inner();
        let rotation_by_gyro = right_jacobian(&turn) * dt;
        f.fixed_view_mut::<3, 3>(ROTATION, ROTATION).copy_from(&turned);
        f.fixed_view_mut::<3, 3>(ROTATION, GYRO_BIAS).copy_from(&-rotation_by_gyro);

        // The sign of noise is free.
        let mut w = SMatrix::<f64, DOF, 12>::zeros();
        w.fixed_view_mut::<3, 3>(ROTATION, 0).copy_from(&rotation_by_gyro);
        for (row, weight) in [(POSITION, 0.5 * dt * dt), (VELOCITY, dt)] {
            w.fixed_view_mut::<3, 3>(row, 0).copy_from(&(by_gyro * weight));
            w.fixed_view_mut::<3, 3>(row, 3).copy_from(&(middle * weight));
        }
        for i in 0..3 {
            w[(GYRO_BIAS + i, 6 + i)] = dt;
            w[(ACCEL_BIAS + i, 9 + i)] = dt;
        }
        (f, w)
    }

    /// The covariance at the end of the step.
    #[must_use]
    pub fn covariance(&self, state: &State, before: &Covariance, noise: &ImuNoise) -> Covariance {
        let (f, w) = self.jacobians(state);
        let mut after = f * before * f.transpose();
        let variances = [noise.gyro, noise.accel, noise.gyro_bias, noise.accel_bias];
        let mut weighted = w;
        for (i, mut column) in weighted.column_iter_mut().enumerate() {
            column.scale_mut(variances[i / 3]);
        }
        after += weighted * w.transpose();
        (after + after.transpose()) * 0.5
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::state::Tangent;
    use crate::state::tests::tangent;

    fn unit(index: usize, value: f64) -> Tangent {
        let mut d = Tangent::zeros();
        d[index] = value;
        d
    }

    fn samples() -> [ImuSample; 2] {
        [
            ImuSample {
                time_s: 0.0,
                gyro: Vector3::new(1.0, -2.0, 0.5),
                accel: Vector3::new(3.0, -1.0, 12.0),
            },
            ImuSample {
                time_s: 0.02,
                gyro: Vector3::new(1.2, -1.6, 0.9),
                accel: Vector3::new(-2.0, 4.0, 9.0),
            },
        ]
    }

    #[test]
    fn a_body_at_rest_stays_at_rest() {
        let rest = |time_s| ImuSample { time_s, gyro: Vector3::zeros(), accel: Vector3::z() * 9.81 };
        let state = State::default();
        let next = Step::new(&state, &rest(0.0), &rest(0.005)).apply(&state);
        assert!(next.minus(&state).norm() < 1e-15);
    }

    #[test]
    fn one_second_of_1_m_s2_is_half_a_meter() {
        let push = |time_s| ImuSample { time_s, gyro: Vector3::zeros(), accel: Vector3::new(1.0, 0.0, 9.81) };
        let mut state = State::default();
        for i in 0..200 {
            let (a, b) = (push(f64::from(i) * 0.005), push(f64::from(i + 1) * 0.005));
            state = Step::new(&state, &a, &b).apply(&state);
        }
        assert!((state.position - Vector3::x() * 0.5).norm() < 1e-12, "{}", state.position);
        assert!((state.velocity - Vector3::x()).norm() < 1e-12);
    }

    proptest! {
        #[test]
        fn jacobians_match_finite_differences(start in tangent()) {
            let [a, b] = samples();
            let state = State::default().plus(&start);
            let next = |s: &State, a: &ImuSample, b: &ImuSample| Step::new(s, a, b).apply(s);
            let nominal = next(&state, &a, &b);
            let (f, w) = Step::new(&state, &a, &b).jacobians(&state);
            let h = 1e-5;
            for i in 0..DOF {
                let plus = next(&state.plus(&unit(i, h)), &a, &b).minus(&nominal);
                let minus = next(&state.plus(&unit(i, -h)), &a, &b).minus(&nominal);
                prop_assert!(((plus - minus) / (2.0 * h) - f.column(i)).norm() < 1e-6, "column {i}");
            }
            for i in 0..6 {
                let mut shift = [Vector3::zeros(); 2];
                shift[i / 3][i % 3] = h;
                let shifted = |sign: f64, s: &ImuSample| ImuSample {
                    gyro: s.gyro + shift[0] * sign,
                    accel: s.accel + shift[1] * sign,
                    ..*s
                };
                let plus = next(&state, &shifted(1.0, &a), &shifted(1.0, &b)).minus(&nominal);
                let minus = next(&state, &shifted(-1.0, &a), &shifted(-1.0, &b)).minus(&nominal);
                prop_assert!(((plus - minus) / (2.0 * h) - w.column(i)).norm() < 1e-6, "noise {i}");
            }
        }
    }

    #[test]
    fn variance_of_the_accelerometer_grows_into_velocity() {
        let [a, b] = samples();
        let state = State::default();
        let noise = ImuNoise { gyro: 0.0, accel: 0.25, gyro_bias: 0.0, accel_bias: 0.0 };
        let p = Step::new(&state, &a, &b).covariance(&state, &Covariance::zeros(), &noise);
        // (0.5 m/s^2 x 0.02 s)^2
        assert!((p[(VELOCITY, VELOCITY)] - 1e-4).abs() < 1e-12);
        assert!((p[(POSITION, POSITION)] - (0.5 * 0.0002_f64).powi(2)).abs() < 1e-15);
    }
}
