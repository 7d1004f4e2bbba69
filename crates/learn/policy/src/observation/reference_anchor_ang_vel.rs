//! How the reference's anchor turns.

use paid_lanes::Real;

use super::{Need, Noise, Observation, Shape, Sink};
use crate::Views;

/// Angular velocity of the reference's anchor body.
#[derive(Clone, Copy, Debug)]
pub struct ReferenceAnchorAngVel;

impl Observation for ReferenceAnchorAngVel {
    const SUMMARY: &'static str = "Angular velocity of the reference's anchor body.";
    const UNIT: &'static str = "rad/s";
    const FRAME: &'static str = "world";
    const SHAPE: Shape = Shape::Vector;
    const AXIAL: bool = true;
    const NEEDS: &'static [Need] = &[Need::Reference];
    const NOISE: Noise = Noise::uniform(0.05, "the authors' public release");

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.reference().anchor_ang_vel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_references_turning_in_world_axes() {
        assert_eq!(written::<ReferenceAnchorAngVel>(), [0.4, 0.5, 0.6]);
    }
}
