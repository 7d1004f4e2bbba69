//! Where the goal is.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Center of the goal.
#[derive(Clone, Copy, Debug)]
pub struct GoalPos;

impl Observation for GoalPos {
    const SUMMARY: &'static str = "Center of the goal.";
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const NEEDS: &'static [Need] = &[Need::Scene];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.scene().goal);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_goals_center() {
        assert_eq!(written::<GoalPos>(), [5.1, 5.2, -0.5]);
    }
}
