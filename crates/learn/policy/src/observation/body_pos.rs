//! Where the bodies are.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Origins of the tracked bodies.
#[derive(Clone, Copy, Debug)]
pub struct BodyPos;

impl Observation for BodyPos {
    const SUMMARY: &'static str = "Origins of the tracked bodies.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "anchor";
    const SHAPE: Shape = Shape::BodyVectors;
    const NEEDS: &'static [Need] = &[Need::Privileged];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        let known = views.privileged();
        for body in known.bodies {
            out.push_vec(known.anchor.point_in_body(body.pos));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn bodies_as_the_anchor_sees_them() {
        assert_eq!(written::<BodyPos>(), [0.0, 0.0, 0.0, 0.5, 0.0, 0.1 - 0.8]);
    }
}
