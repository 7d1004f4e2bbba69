//! How the reference's joints move.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Joint velocities of the reference.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceJointVel;

impl Observation for ReferenceJointVel {
    const SUMMARY: &'static str = "Joint velocities of the reference.";
    const UNIT: &'static str = "rad/s";
    const FRAME: &'static str = "joint";
    const SHAPE: Shape = Shape::Joints;
    const NEEDS: &'static [Need] = &[Need::Reference];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_all(views.reference().joint_vel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_references_velocities_not_the_robots() {
        assert_eq!(written::<ReferenceJointVel>(), [4.5, -4.6]);
    }
}
