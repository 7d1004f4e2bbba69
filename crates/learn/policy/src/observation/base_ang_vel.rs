//! How the base turns.

use paid_lanes::Real;

use super::{Noise, Observation, Shape, Sink};
use crate::Views;

/// Angular velocity of the base, as a gyroscope measures it.
#[derive(Clone, Copy, Debug)]
pub struct BaseAngVel;

impl Observation for BaseAngVel {
    const SUMMARY: &'static str = "Angular velocity of the base, as a gyroscope measures it.";
    const UNIT: &'static str = "rad/s";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const AXIAL: bool = true;
    const SENSED: bool = true;
    const NOISE: Noise = Noise::uniform(0.2, "the authors' public release");

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.robot.base_ang_vel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_gyroscopes_reading() {
        assert_eq!(written::<BaseAngVel>(), [0.1, 0.2, 0.3]);
    }
}
