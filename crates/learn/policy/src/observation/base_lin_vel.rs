//! How the base moves.

use paid_lanes::Real;

use super::{Need, Observation, Shape, Sink};
use crate::Views;

/// Velocity of the base.
#[derive(Clone, Copy, Debug)]
pub struct BaseLinVel;

impl Observation for BaseLinVel {
    const SUMMARY: &'static str = "Velocity of the base.";
    const UNIT: &'static str = "m/s";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Vector;
    const NEEDS: &'static [Need] = &[Need::Privileged];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        out.push_vec(views.privileged().base_lin_vel);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observation::fixture::written;

    #[test]
    fn the_bases_own_velocity() {
        assert_eq!(written::<BaseLinVel>(), [0.7, 0.8, 0.9]);
    }
}
