//! How uncertain the seen position of an object is.

use paid_lanes::Real;

/// Gaussian noise of a seen position, larger for a fast and for a far object: standard deviation
/// `c_min + |v| / c_vel + d / c_dist` `[m]` on every component (paper, physics-guided randomization).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PositionNoise {
    /// Constant part `[m]`.
    pub c_min: f64,
    /// Divisor of the object's speed relative to the base `[1/s]`.
    pub c_vel: f64,
    /// Divisor of the object's distance.
    pub c_dist: f64,
}

impl PositionNoise {
    /// Standard deviation `[m]` for an object at `distance` `[m]` that moves at `speed` `[m/s]` relative to the base.
    #[inline(always)]
    pub fn deviation<V: Real>(&self, speed: V, distance: V) -> V {
        V::c(self.c_min) + speed * V::c(1.0 / self.c_vel) + distance * V::c(1.0 / self.c_dist)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn deviation_grows_with_speed_and_distance() {
        let noise = PositionNoise { c_min: 0.01, c_vel: 50.0, c_dist: 100.0 };
        let value: f64 = noise.deviation(2.0, 3.0);
        assert!((value - (0.01 + 0.04 + 0.03)).abs() < 1e-12);
    }
}
