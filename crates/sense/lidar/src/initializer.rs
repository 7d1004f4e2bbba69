//! The start: gravity and gyroscope bias from standing still.

use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

use crate::config::Config;
use crate::gravity::{GRAVITY, Gravity};
use crate::health::NotStill;
use crate::imu::ImuSample;
use crate::state::{
    ACCEL_BIAS, Covariance, GRAVITY_DIRECTION, GYRO_BIAS, LIDAR_POSITION, LIDAR_ROTATION, POSITION, ROTATION,
    State, VELOCITY,
};

/// Angular velocity of a sensor at rest is below this `[rad/s]`: a Mid-360's offset is up to 0.046, a standing robot sways by 0.02.
const MOST_TURN: f64 = 0.08;
/// Deviation of a resting sensor's acceleration is below this `[m/s^2]`: a scanner shakes it by 0.36, each step of a walk by several.
const MOST_SHAKE: f64 = 0.5;
/// Fewest samples of the mean.
const MIN_SAMPLES: usize = 11;

/// A state to start from.
#[derive(Clone, Debug)]
pub struct Start {
    /// At rest at the origin of the odometry frame.
    pub state: State,
    /// Its covariance.
    pub covariance: Covariance,
    /// Factor that makes the mean acceleration 9.81 m/s^2.
    pub accel_scale: f64,
    /// The newest sample.
    pub last: ImuSample,
}

/// Collects samples until they come from standing still.
#[derive(Clone, Debug, Default)]
pub struct Initializer {
    samples: Vec<ImuSample>,
    refused: Option<NotStill>,
}

impl Initializer {
    /// Why the last stretch of samples was refused.
    #[must_use]
    pub fn refused(&self) -> Option<NotStill> {
        self.refused
    }

    /// Adds a sample; the start, once the newest `config.standstill_s` are from standing still.
    pub fn push(&mut self, sample: ImuSample, config: &Config) -> Option<Start> {
        self.samples.push(sample);
        let first = self.samples.first()?;
        if sample.time_s - first.time_s < config.standstill_s || self.samples.len() < MIN_SAMPLES {
            return None;
        }
        match self.judge(config) {
            Ok(start) => Some(start),
            Err(why) => {
                self.refused = Some(why);
                // The later half may be the begin of a rest.
                self.samples.drain(..self.samples.len() / 2);
                None
            }
        }
    }

    fn judge(&self, config: &Config) -> Result<Start, NotStill> {
        let gyro = Statistics::of(self.samples.iter().map(|s| s.gyro));
        let accel = Statistics::of(self.samples.iter().map(|s| s.accel));
        let turn = gyro.mean.norm().max(gyro.deviation);
        if turn > MOST_TURN {
            return Err(NotStill::Turns { found: turn, most: MOST_TURN });
        }
        if accel.deviation > MOST_SHAKE {
            return Err(NotStill::Shakes { found: accel.deviation, most: MOST_SHAKE });
        }
        let length = accel.mean.norm();
        if !(0.9 * GRAVITY..=1.1 * GRAVITY).contains(&length) {
            return Err(NotStill::NotGravity { found: length });
        }
        let Some(&last) = self.samples.last() else {
            return Err(NotStill::NotGravity { found: 0.0 });
        };
        let state = State {
            rotation: upright(&(accel.mean / length)),
            lidar_rotation: config.imu_from_lidar.rotation,
            lidar_position: config.imu_from_lidar.translation.vector,
            gyro_bias: gyro.mean,
            gravity: Gravity::along(&-Vector3::z()),
            ..State::default()
        };
        Ok(Start { state, covariance: initial_covariance(), accel_scale: GRAVITY / length, last })
    }
}

/// What is known at the start. Position, rotation and with them the frame are zero by definition, so all doubt about the tilt is
/// gravity's; the published method begins with 1 there and lets the first scans decide.
fn initial_covariance() -> Covariance {
    let mut p = Covariance::zeros();
    let parts = [
        (POSITION, 3, 1e-6),
        (ROTATION, 3, 1e-6),
        (LIDAR_ROTATION, 3, 1e-5),
        (LIDAR_POSITION, 3, 1e-5),
        (VELOCITY, 3, 1e-2),
        (GYRO_BIAS, 3, 1e-4),
        (ACCEL_BIAS, 3, 1e-3),
        (GRAVITY_DIRECTION, 2, 1e-5),
    ];
    for (at, width, variance) in parts {
        for i in at..at + width {
            p[(i, i)] = variance;
        }
    }
    p
}

/// The rotation from the IMU frame to a frame with z along `up` (unit vector, IMU frame) and x where the IMU's x axis points. Holds
/// for an IMU that hangs upside down.
fn upright(up: &Vector3<f64>) -> UnitQuaternion<f64> {
    // Lying on its side with x vertical, the IMU's y axis gives the heading.
    let ahead = if up.x.abs() < 0.99 { Vector3::x() } else { Vector3::y() };
    let x = (ahead - up * up.dot(&ahead)).normalize();
    let y = up.cross(&x);
    let rows = Matrix3::from_rows(&[x.transpose(), y.transpose(), up.transpose()]);
    UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(rows))
}

/// Mean and deviation (root of the summed variances of the axes).
struct Statistics {
    mean: Vector3<f64>,
    deviation: f64,
}

impl Statistics {
    fn of(values: impl Iterator<Item = Vector3<f64>> + Clone) -> Self {
        let count = values.clone().count().max(1) as f64;
        let mean = values.clone().sum::<Vector3<f64>>() / count;
        let variance = values.map(|v| (v - mean).norm_squared()).sum::<f64>() / count;
        Self { mean, deviation: variance.sqrt() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::so3::exp;

    fn feed(samples: impl Iterator<Item = ImuSample>) -> (Option<Start>, Initializer) {
        let mut initializer = Initializer::default();
        let config = Config::default();
        for sample in samples {
            if let Some(start) = initializer.push(sample, &config) {
                return (Some(start), initializer);
            }
        }
        (None, initializer)
    }

    fn at_rest(imu_from_up: UnitQuaternion<f64>, length: f64) -> impl Iterator<Item = ImuSample> + Clone {
        (0..120).map(move |i| ImuSample {
            time_s: f64::from(i) * 0.005,
            gyro: Vector3::new(0.01, -0.02, 0.005),
            accel: imu_from_up * Vector3::z() * length,
        })
    }

    #[test]
    fn standing_still_gives_gravity_and_gyro_bias() {
        let tilt = exp(&Vector3::new(0.2, -0.1, 0.0));
        let (start, _) = feed(at_rest(tilt.inverse(), 9.7));
        let start = start.expect("still");
        assert!((start.state.rotation * (tilt.inverse() * Vector3::z()) - Vector3::z()).norm() < 1e-12);
        assert!((start.state.gyro_bias - Vector3::new(0.01, -0.02, 0.005)).norm() < 1e-12);
        assert!((start.accel_scale - 9.81 / 9.7).abs() < 1e-12);
    }

    #[test]
    fn a_large_offset_and_a_shaking_scanner_pass_for_standing_still() {
        let offset = Vector3::new(0.03, -0.03, 0.018);
        let samples = (0..120).map(|i| {
            let time_s = f64::from(i) * 0.005;
            // Amplitudes of a tone are sqrt(2) times its deviations. The robot sways by 0.004 rad/s the way the offset points.
            let tone = core::f64::consts::SQRT_2 * (core::f64::consts::TAU * 76.7 * time_s).sin();
            ImuSample {
                time_s,
                gyro: offset * (1.0 + 0.004 / 0.046) + Vector3::repeat(0.017 * tone),
                accel: Vector3::z() * 9.74 + Vector3::new(0.12, 0.15, 0.30) * tone,
            }
        });
        let (start, initializer) = feed(samples);
        let start = start.unwrap_or_else(|| panic!("{:?}", initializer.refused()));
        assert!((start.state.gyro_bias - offset).norm() < 0.005, "{}", start.state.gyro_bias);
        assert!((start.accel_scale - 9.81 / 9.74).abs() < 0.002, "{}", start.accel_scale);
    }

    #[test]
    fn an_imu_upside_down_starts_with_its_x_axis_ahead() {
        let (start, _) = feed(at_rest(exp(&Vector3::new(core::f64::consts::PI, 0.0, 0.0)), 9.81));
        let rotation = start.expect("still").state.rotation;
        assert!((rotation * Vector3::x() - Vector3::x()).norm() < 1e-9);
        assert!((rotation * Vector3::z() + Vector3::z()).norm() < 1e-9);
    }

    #[test]
    fn a_moving_start_is_refused_with_its_reason_and_a_later_rest_is_taken() {
        let walking = (0..400).map(|i| {
            let time_s = f64::from(i) * 0.005;
            let swing = (time_s * 12.0).sin();
            ImuSample { time_s, gyro: Vector3::y() * 0.4 * swing, accel: Vector3::z() * (9.81 + 2.0 * swing) }
        });
        let (start, initializer) = feed(walking.clone());
        assert!(start.is_none());
        let why = initializer.refused().expect("a reason").to_string();
        assert!(why.starts_with("the sensor turns: expected at most 0.08 rad/s, found 0.2"), "{why}");

        let rest =
            at_rest(UnitQuaternion::identity(), 9.81).map(|s| ImuSample { time_s: s.time_s + 2.0, ..s });
        let (start, _) = feed(
            walking
                .take(300)
                .chain(rest.clone())
                .chain(rest.map(|s| ImuSample { time_s: s.time_s + 0.6, ..s })),
        );
        assert!(start.is_some());
    }

    #[test]
    fn acceleration_in_g_is_refused_by_name() {
        let (start, initializer) = feed(at_rest(UnitQuaternion::identity(), 1.0));
        assert!(start.is_none());
        assert_eq!(initializer.refused(), Some(NotStill::NotGravity { found: 1.0 }));
    }
}
