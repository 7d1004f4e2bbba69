//! Where the ball was.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Center of the ball where it was shown 5, 10 and 15 control steps ago (0.1, 0.2 and 0.3 s at 50 Hz), in the base frame of now.
///
/// Beside `ball_pos` it tells a network without memory how the ball moves. Where an episode or a kick begins, all three are the place
/// of the first look.
#[derive(Clone, Copy, Debug)]
pub struct BallBefore;

impl Observation for BallBefore {
    const SUMMARY: &'static str =
        "Center of the ball where it was shown 5, 10 and 15 control steps ago, in the base frame of now.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::ThreeVectors;
    const NEEDS: &'static [Need] = &[Need::Scene];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        for place in views.scene().ball_before {
            out.push_vec(place);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_ball_where_it_was_the_latest_first() {
        assert_eq!(written::<BallBefore>(), [1.0, 1.3, -0.6, 0.9, 1.4, -0.5, 0.8, 1.5, -0.4]);
    }
}
