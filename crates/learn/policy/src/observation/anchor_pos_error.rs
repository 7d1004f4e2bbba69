//! How far the reference's anchor is away.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// The reference's anchor seen from the robot's.
#[derive(Clone, Copy, Debug)]
pub struct AnchorPosError;

impl Observation for AnchorPosError {
    const SUMMARY: &'static str = "The reference's anchor seen from the robot's.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor";
    const SHAPE: Shape = Shape::Vector;
    const NEEDS: &'static [Need] = &[Need::Privileged, Need::Reference];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        let anchor = &views.privileged().anchor;
        out.push_vec(anchor.point_in_body(views.reference().anchor.pos));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn a_reference_ahead_is_ahead_in_the_anchors_frame() {
        assert_eq!(written::<AnchorPosError>(), [1.0, 0.0, 0.9 - 0.8]);
    }
}
