//! Where the reference's joints are.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Joint angles of the reference.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceJointPos;

impl Observation for ReferenceJointPos {
    const SUMMARY: &'static str = "Joint angles of the reference.";
    const UNIT: &'static str = "rad";
    const FRAME: &'static str = "joint";
    const SHAPE: Shape = Shape::Joints;
    const NEEDS: &'static [Need] = &[Need::Reference];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_all(views.reference().joint_pos);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_references_angles_not_the_robots() {
        assert_eq!(written::<ReferenceJointPos>(), [3.5, -3.6]);
    }
}
