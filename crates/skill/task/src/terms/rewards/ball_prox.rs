//! Nearness to the ball.

use paid_lanes::Real;
use serde::{Deserialize, Serialize};

use super::kernel::gaussian;
use crate::scene::kick::{horizontal2, is_set};
use crate::{Requirement, RewardTerm, TermInput, reward_term};

/// Which point of the robot a distance is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ProximityPoint {
    /// The anchor (torso): release.
    Anchor,
    /// The base (pelvis): paper.
    Base,
}

reward_term! {
    /// Horizontal distance between robot and ball: `exp(-d^2 / sigma^2)`, frozen at the first contact.
    pub struct BallProx {
        /// Width of the kernel.
        sigma: f64 = 4.0, "m", positive, "the authors' public release";
        /// Point of the robot that the distance is measured from: `anchor` or `base`.
        from: ProximityPoint = ProximityPoint::Anchor, "", point, "the release takes the torso; the paper says pelvis";
        /// True: the value at the first contact stays; false: it falls as the ball flies away.
        frozen: bool = true, "", switch, "the authors' public release; the paper";
    }
}

impl RewardTerm for BallProx {
    const UNIT: &'static str = "m";
    const FRAME: &'static str = "world, horizontal";
    const NEEDS: &'static [Requirement] = &[Requirement::Ball];

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let kick = &input.group.kick;
        let (k, point) = match self.from {
            ProximityPoint::Anchor => (0, input.anchor().pos),
            ProximityPoint::Base => (1, input.state.bodies[0].pos),
        };
        let now2 = horizontal2(input.state.ball.pos - point);
        let kept = V::select(is_set(kick.touched), kick.distance2[k], now2);
        gaussian(if self.frozen { kept } else { now2 }, self.sigma)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};

    #[test]
    fn height_is_ignored_and_the_distance_at_the_first_contact_stays() {
        let mut fixture = Fixture::new();
        fixture.state.ball.pos.0 = [0.0, 4.0, 0.1];
        let term = BallProx::default();
        close(term.value(&fixture.input()), (-1.0_f64).exp());
        fixture.group.kick.touched = 1.0;
        fixture.group.kick.distance2 = [0.0, 32.0];
        close(term.value(&fixture.input()), 1.0);
        close(BallProx { frozen: false, ..term.clone() }.value(&fixture.input()), (-1.0_f64).exp());
        let term = BallProx { from: ProximityPoint::Base, ..term };
        close(term.value(&fixture.input()), (-2.0_f64).exp());
    }
}
