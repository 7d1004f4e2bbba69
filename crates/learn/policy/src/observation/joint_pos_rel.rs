//! Where the joints are.

use paid_lanes::Real;

use super::{Noise, Observation, Shape, Sink};
use crate::Views;

/// Joint angles relative to the rest pose.
#[derive(Clone, Copy, Debug)]
pub struct JointPosRel;

impl Observation for JointPosRel {
    const SUMMARY: &'static str = "Joint angles relative to the rest pose.";
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "joint";
    const SHAPE: Shape = Shape::Joints;
    const SENSED: bool = true;
    const NOISE: Noise =
        Noise::uniform(0.01, "play and calibration of the encoders; the authors' public release");

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_all(views.robot.joint_pos_rel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_robots_angles_from_rest() {
        assert_eq!(written::<JointPosRel>(), [0.5, -0.6]);
    }
}
