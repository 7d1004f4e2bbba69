//! Where the ball will be.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Center of the ball when the reference strikes, as predicted from its velocity.
///
/// The caller predicts, from what it knows of the ball's velocity and of how fast balls slow down. The paper's policy sees the
/// ball where it is and is recurrent.
#[derive(Clone, Copy, Debug)]
pub struct BallAtStrike;

impl Observation for BallAtStrike {
    const SUMMARY: &'static str =
        "Center of the ball when the reference strikes, as predicted from its velocity.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const NEEDS: &'static [Need] = &[Need::Scene, Need::Reference];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.scene().ball_at_strike);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_ball_where_it_will_be() {
        assert_eq!(written::<BallAtStrike>(), [2.1, 2.2, -0.7]);
    }
}
