//! How the reference's anchor is turned.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Rotation from the robot's anchor to the reference's.
#[derive(Clone, Copy, Debug)]
pub struct AnchorOriError;

impl Observation for AnchorOriError {
    const SUMMARY: &'static str = "Rotation from the robot's anchor to the reference's.";
    const UNIT: &'static str = "";
    const FRAME: &'static str = "anchor";
    const SHAPE: Shape = Shape::Rotation;
    const NEEDS: &'static [Need] = &[Need::Privileged, Need::Reference];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        let anchor = &views.privileged().anchor;
        out.push_rotation(&anchor.rot.tr_mul_mat(&views.reference().anchor.rot));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn a_reference_a_quarter_turn_to_the_right() {
        assert_eq!(written::<AnchorOriError>(), [0.0, 1.0, -1.0, 0.0, 0.0, 0.0]);
    }
}
