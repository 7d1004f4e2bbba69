//! Where the ball is.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Center of the ball.
#[derive(Clone, Copy, Debug)]
pub struct BallPos;

impl Observation for BallPos {
    const SUMMARY: &'static str = "Center of the ball.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const NEEDS: &'static [Need] = &[Need::Scene];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.scene().ball);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_ball_where_it_is() {
        assert_eq!(written::<BallPos>(), [1.1, 1.2, -0.6]);
    }
}
