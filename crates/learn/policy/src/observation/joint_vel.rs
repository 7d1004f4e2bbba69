//! How the joints move.

use paid_lanes::Real;

use super::{Noise, Observation, Shape, Sink};
use crate::Views;

/// Joint velocities.
#[derive(Clone, Copy, Debug)]
pub struct JointVel;

impl Observation for JointVel {
    const SUMMARY: &'static str = "Joint velocities.";
    const UNIT: &'static str = "rad/s";
    const FRAME: &'static str = "joint";
    const SHAPE: Shape = Shape::Joints;
    const SENSED: bool = true;
    const NOISE: Noise =
        Noise::uniform(0.5, "velocities are differences of encoder readings; the authors' public release");

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_all(views.robot.joint_vel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_robots_velocities() {
        assert_eq!(written::<JointVel>(), [1.5, -1.6]);
    }
}
