//! Which way is down.

use paid_lanes::Real;

use super::{Noise, Observation, Shape, Sink};
use crate::Views;

/// Direction of gravity in the base frame, a unit vector.
#[derive(Clone, Copy, Debug)]
pub struct ProjectedGravity;

impl Observation for ProjectedGravity {
    const SUMMARY: &'static str = "Direction of gravity in the base frame, a unit vector.";
    const UNIT: &'static str = "";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const SENSED: bool = true;
    const NOISE: Noise = Noise::uniform(
        0.05,
        "3 degrees of attitude error of an inertial measurement unit; the authors' public release",
    );

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(crate::projected_gravity(&views.robot.base_rot));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn a_turn_about_the_vertical_does_not_move_gravity() {
        assert_eq!(written::<ProjectedGravity>(), [0.0, 0.0, -1.0]);
    }
}
