//! The three terms.

use paid_lanes::Real;
use paid_policy::Views;
use paid_policy::observation::{Need, Observation, Shape, Sink};
use paid_task::{RewardTerm, TermInput, TerminationTerm, parameters, reward_term};

reward_term! {
    /// Mean over the joints of the squared torque, in units of `scale_nm` squared.
    pub struct Effort {
        /// Torque that counts as 1.
        scale_nm: f64 = 20.0, "N m", positive, "what a knee needs to stand";
    }
}

impl RewardTerm for Effort {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "joint";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let torques = &input.state().joint_torque;
        let mut sum = V::zero();
        for torque in torques {
            sum = torque.mul_add(*torque, sum);
        }
        sum * V::c(1.0 / (torques.len() as f64 * self.scale_nm * self.scale_nm))
    }
}

parameters! {
    /// Horizontal distance of the feet.
    pub struct FeetApart {
        /// Largest distance; 0 switches the term off.
        limit_m: f64 = 0.0, "m", not_negative, "off";
    }
}

impl TerminationTerm for FeetApart {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world, horizontal";

    fn is_on(&self) -> bool {
        self.limit_m > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        let apart = input.foot(0).pos - input.foot(1).pos;
        apart.x().mul_add(apart.x(), apart.y() * apart.y()).gt(V::c(self.limit_m * self.limit_m))
    }
}

/// Sine of the angle between the base's z axis and the vertical.
#[derive(Clone, Copy, Debug)]
pub struct Tilt;

impl Observation for Tilt {
    const SUMMARY: &'static str = "Sine of the angle between the base's z axis and the vertical.";
    const UNIT: &'static str = "";
    const FRAME: &'static str = "base";
    const SHAPE: Shape = Shape::Scalar;
    const NEEDS: &'static [Need] = &[];

    #[inline(always)]
    fn write<V: Real>(views: &Views<'_, V>, out: &mut impl Sink<V>) {
        let gravity = paid_policy::projected_gravity(&views.robot.base_rot);
        out.push(gravity.x().mul_add(gravity.x(), gravity.y() * gravity.y()).sqrt());
    }
}
