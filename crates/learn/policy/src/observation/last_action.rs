//! What the policy did last.

use paid_lanes::Real;

use super::{Observation, Shape, Sink};
use crate::Views;

/// The last action, before scaling.
#[derive(Clone, Copy, Debug)]
pub struct LastAction;

impl Observation for LastAction {
    const SUMMARY: &'static str = "The last action, before scaling.";
    const UNIT: &'static str = "";
    const FRAME: &'static str = "joint";
    const SHAPE: Shape = Shape::Joints;

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_all(views.robot.last_action);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_last_action_unscaled() {
        assert_eq!(written::<LastAction>(), [2.5, -2.6]);
    }
}
