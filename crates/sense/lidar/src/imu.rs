//! The IMU's samples.

use nalgebra::Vector3;

/// One sample of the IMU, in the IMU frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuSample {
    /// When it was taken `[s]`, by the sensor's clock.
    pub time_s: f64,
    /// Angular velocity `[rad/s]`.
    pub gyro: Vector3<f64>,
    /// Specific force `[m/s^2]`: +9.81 upward at rest.
    pub accel: Vector3<f64>,
}

impl ImuSample {
    /// Whether every number is finite.
    #[must_use]
    pub fn is_finite(&self) -> bool {
        self.time_s.is_finite() && self.gyro.iter().chain(self.accel.iter()).all(|x| x.is_finite())
    }

    /// The sample at `time_s` on the straight line from `self` to `next`.
    #[must_use]
    pub fn between(&self, next: &Self, time_s: f64) -> Self {
        let span = next.time_s - self.time_s;
        let share = if span > 0.0 { ((time_s - self.time_s) / span).clamp(0.0, 1.0) } else { 1.0 };
        Self { time_s, gyro: self.gyro.lerp(&next.gyro, share), accel: self.accel.lerp(&next.accel, share) }
    }

    /// The largest acceleration of an axis, either way `[m/s^2]`: at the end of the range it saturates.
    #[must_use]
    pub fn peak_accel(&self) -> f64 {
        self.accel.amax()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_between_two_lies_on_the_line() {
        let a = ImuSample { time_s: 1.0, gyro: Vector3::x(), accel: Vector3::zeros() };
        let b = ImuSample { time_s: 1.01, gyro: Vector3::x() * 3.0, accel: Vector3::z() * -8.0 };
        let c = a.between(&b, 1.0025);
        assert!((c.gyro.x - 1.5).abs() < 1e-9 && (c.accel.z + 2.0).abs() < 1e-9, "{c:?}");
        assert_eq!(b.peak_accel(), 8.0);
    }
}
