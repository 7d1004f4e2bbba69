//! State, covariance and the sample at which they hold.

use std::collections::VecDeque;

use nalgebra::{Isometry3, SMatrix, Vector3};

use crate::config::Config;
use crate::imu::ImuSample;
use crate::initializer::Start;
use crate::propagate::{ImuNoise, Step};
use crate::state::{Covariance, DOF, POSITION, ROTATION, State, Tangent, VELOCITY};
use crate::undistort::Motion;
use crate::update::Posterior;

/// Variance of gyroscope and accelerometer over a gap, where the line between two samples is a guess.
const GAP_GYRO: f64 = 1.0;
const GAP_ACCEL: f64 = 25.0;
/// An impact is over within two samples, so their mean is off by up to this share of their difference.
const IMPACT_SHARE: f64 = 0.25;

/// The filter.
#[derive(Clone, Debug)]
pub struct Filter {
    /// The state at [`Filter::time_s`].
    pub state: State,
    covariance: Covariance,
    last: ImuSample,
    accel_scale: f64,
}

impl Filter {
    /// A filter at rest.
    #[must_use]
    pub fn new(start: Start) -> Self {
        let mut last = start.last;
        last.accel *= start.accel_scale;
        Self { state: start.state, covariance: start.covariance, last, accel_scale: start.accel_scale }
    }

    /// Time of the state `[s]`.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.last.time_s
    }

    /// Covariance of the state.
    #[must_use]
    pub fn covariance(&self) -> &Covariance {
        &self.covariance
    }

    /// Covariance of position, rotation and velocity.
    #[must_use]
    pub fn pose_covariance(&self) -> SMatrix<f64, 9, 9> {
        let at = |i: usize| [POSITION, ROTATION, VELOCITY][i / 3] + i % 3;
        SMatrix::from_fn(|i, k| self.covariance[(at(i), at(k))])
    }

    /// Angular velocity in the IMU frame, without bias `[rad/s]`.
    #[must_use]
    pub fn angular_velocity(&self) -> Vector3<f64> {
        self.last.gyro - self.state.gyro_bias
    }

    /// Predicts to `time_s` with the samples up to there, which it takes out of the queue, and records the motion.
    pub fn predict(
        &mut self,
        samples: &mut VecDeque<ImuSample>,
        time_s: f64,
        config: &Config,
        motion: &mut Motion,
    ) {
        while let Some(next) = samples.front().copied() {
            let next = self.scaled(&next);
            if next.time_s > time_s {
                if self.last.time_s < time_s {
                    let cut = self.last.between(&next, time_s);
                    self.step(cut, config, motion);
                }
                return;
            }
            samples.pop_front();
            if next.time_s > self.last.time_s {
                self.step(next, config, motion);
            }
        }
    }

    fn scaled(&self, sample: &ImuSample) -> ImuSample {
        ImuSample { accel: sample.accel * self.accel_scale, ..*sample }
    }

    fn step(&mut self, next: ImuSample, config: &Config, motion: &mut Motion) {
        let step = Step::new(&self.state, &self.last, &next);
        motion.push(self.last.time_s, &self.state, &step);
        let noise = noise_of(&self.last, &next, self.accel_scale, config);
        self.covariance = step.covariance(&self.state, &self.covariance, &noise);
        self.state = step.apply(&self.state);
        self.last = next;
    }

    /// Predicted pose of the IMU at `time_s`, which is not before the state's time; `None` beyond the newest sample.
    #[must_use]
    pub fn ahead(&self, samples: &VecDeque<ImuSample>, time_s: f64) -> Option<Isometry3<f64>> {
        if samples.back()?.time_s < time_s {
            return None;
        }
        let mut state = self.state.clone();
        let mut last = self.last;
        for sample in samples.iter().filter(|s| s.time_s > self.last.time_s) {
            let mut next = self.scaled(sample);
            let done = next.time_s >= time_s;
            if done {
                next = last.between(&next, time_s);
            }
            state = Step::new(&state, &last, &next).apply(&state);
            last = next;
            if done {
                break;
            }
        }
        Some(state.odometry_from_imu())
    }

    /// Takes a corrected state.
    pub fn correct(&mut self, posterior: Posterior) {
        self.state = posterior.state;
        self.covariance = posterior.covariance;
    }

    /// Bounds the doubt about the speed along `direction` by `usual_speed` `[m/s]`: if it is larger, a measurement of zero with just
    /// the deviation that brings it down there. Where no plane holds the position, this keeps it from running away ever faster.
    pub fn expect_usual_speed(&mut self, direction: &Vector3<f64>, usual_speed: f64) {
        let mut row = Tangent::zeros();
        row.fixed_rows_mut::<3>(VELOCITY).copy_from(direction);
        let spread: SMatrix<f64, DOF, 1> = self.covariance * row;
        let (doubt, usual) = (row.dot(&spread), usual_speed * usual_speed);
        if doubt <= usual {
            return;
        }
        // 1 / usual = 1 / doubt + 1 / noise
        let variance = doubt + usual * doubt / (doubt - usual);
        let gain = spread / variance;
        let change = gain * -self.state.velocity.dot(direction);
        let reset = self.state.reset_jacobian(&change);
        self.state = self.state.plus(&change);
        let corrected = self.covariance - gain * spread.transpose();
        let corrected = reset * corrected * reset.transpose();
        self.covariance = (corrected + corrected.transpose()) * 0.5;
    }
}

/// Noise of a step between two samples, scaled by `accel_scale`: more in impacts, at the end of the accelerometer's range, and over a gap.
fn noise_of(a: &ImuSample, b: &ImuSample, accel_scale: f64, config: &Config) -> ImuNoise {
    let mut noise = config.imu_noise;
    noise.accel += (IMPACT_SHARE * (b.accel - a.accel).norm()).powi(2);
    if a.peak_accel().max(b.peak_accel()) > 0.98 * config.accel_range * accel_scale {
        noise.accel = noise.accel.max(config.saturated_variance);
    }
    if b.time_s - a.time_s > config.imu_gap_s {
        noise.gyro = noise.gyro.max(GAP_GYRO);
        noise.accel = noise.accel.max(GAP_ACCEL);
    }
    noise
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::initializer::Initializer;

    fn at_rest() -> Filter {
        at_rest_with(9.81)
    }

    /// At rest with an accelerometer that measures this of gravity `[m/s^2]`.
    fn at_rest_with(gravity: f64) -> Filter {
        let mut initializer = Initializer::default();
        let config = Config::default();
        let sample = |i: i32| ImuSample {
            time_s: f64::from(i) * 0.005,
            gyro: Vector3::zeros(),
            accel: Vector3::z() * gravity,
        };
        (0..200).find_map(|i| initializer.push(sample(i), &config)).map(Filter::new).expect("still")
    }

    #[test]
    fn prediction_stops_at_the_wanted_time_between_two_samples() {
        let mut filter = at_rest();
        let begin = filter.time_s();
        let mut samples: VecDeque<ImuSample> = (1..5)
            .map(|i| ImuSample {
                time_s: begin + f64::from(i) * 0.005,
                gyro: Vector3::zeros(),
                accel: Vector3::new(2.0, 0.0, 9.81),
            })
            .collect();
        let ahead = filter.ahead(&samples, begin + 0.012).expect("samples");
        filter.predict(&mut samples, begin + 0.012, &Config::default(), &mut Motion::default());
        assert!((filter.time_s() - begin - 0.012).abs() < 1e-12);
        assert_eq!(samples.len(), 2);
        // 1 m/s^2 for the first 5 ms (mean of 0 and 2), then 2 m/s^2 for 7 ms.
        assert!((filter.state.velocity.x - (0.005 + 0.014)).abs() < 1e-9, "{}", filter.state.velocity);
        assert!((ahead.translation.vector - filter.state.position).norm() < 1e-12);
    }

    #[test]
    fn a_sample_at_the_end_of_the_range_leaves_the_velocity_in_doubt() {
        let of_sensor = |gravity: f64, accel: f64| {
            let mut filter = at_rest_with(gravity);
            let time_s = filter.time_s() + 0.005;
            let sample = ImuSample { time_s, gyro: Vector3::zeros(), accel: Vector3::z() * accel };
            filter.predict(&mut VecDeque::from([sample]), time_s, &Config::default(), &mut Motion::default());
            filter.pose_covariance()[(8, 8)] - 1e-2
        };
        let deviation = |accel: f64| of_sensor(9.81, accel);
        // 400 m^2/s^4 x (5 ms)^2
        assert!((deviation(39.24) - 0.01).abs() < 1e-4, "{}", deviation(39.24));
        // A quarter of the difference of 20.19 m/s^2 from sample to sample, squared: 25.5, and 0.1.
        assert!((deviation(30.0) - 25.6 * 2.5e-5).abs() < 5e-5, "{}", deviation(30.0));
        // An accelerometer that measures too much of gravity, and so of everything, ends its range where the others do.
        let scaled = of_sensor(1.05 * 9.81, 39.24);
        assert!((scaled - 0.01).abs() < 1e-4, "{scaled}");
    }

    #[test]
    fn the_usual_speed_pulls_a_velocity_in_doubt_to_zero() {
        let mut filter = at_rest();
        filter.state.velocity = Vector3::new(3.0, 1.0, 0.0);
        filter.covariance[(VELOCITY, VELOCITY)] = 10.0;
        filter.expect_usual_speed(&Vector3::x(), 1.0);
        // A variance of 10 becomes 1: nine tenths of the way to zero.
        assert!((filter.state.velocity.x - 0.3).abs() < 1e-9);
        assert!((filter.state.velocity.y - 1.0).abs() < 1e-9);
        assert!((filter.covariance[(VELOCITY, VELOCITY)] - 1.0).abs() < 1e-9);
        filter.expect_usual_speed(&Vector3::x(), 1.1);
        assert!((filter.state.velocity.x - 0.3).abs() < 1e-9, "a smaller doubt is left alone");
    }
}
