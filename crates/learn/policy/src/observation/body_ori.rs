//! How the bodies are turned.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Orientations of the tracked bodies.
#[derive(Clone, Copy, Debug)]
pub struct BodyOri;

impl Observation for BodyOri {
    const SUMMARY: &'static str = "Orientations of the tracked bodies.";
    const UNIT: &'static str = "";
    const FRAME: &'static str = "anchor";
    const SHAPE: Shape = Shape::BodyRotations;
    const NEEDS: &'static [Need] = &[Need::Privileged];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        let known = views.privileged();
        for body in known.bodies {
            out.push_rotation(&known.anchor.rot.tr_mul_mat(&body.rot));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn orientations_as_the_anchor_sees_them() {
        assert_eq!(written::<BodyOri>(), [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0]);
    }
}
