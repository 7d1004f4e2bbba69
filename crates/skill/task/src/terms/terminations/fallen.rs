//! A fall, without a reference.

use paid_lanes::{Mask, Real};
use paid_physics::BodyState;
use paid_policy::projected_gravity;

use crate::{TermInput, TerminationTerm, parameters};

parameters! {
    /// Base below a height or tilted beyond an angle: for tasks without a reference.
    pub struct Fallen {
        /// Least height of the base above the plane z = 0; 0: any height.
        height_m: f64 = 0.0, "m", not_negative, "off";
        /// Largest angle between the base's z axis and the vertical; 0: any angle.
        tilt_deg: f64 = 0.0, "deg", not_negative, "off";
    }
}

impl TerminationTerm for Fallen {
    const UNIT: &'static str = "m, deg";
    const FRAME: &'static str = "world, vertical";

    fn is_on(&self) -> bool {
        self.height_m > 0.0 || self.tilt_deg > 0.0
    }

    #[inline(always)]
    fn fails<V: Real>(&self, input: &TermInput<'_, V>) -> V::Mask {
        self.is_down(&input.state.bodies[0])
    }
}

impl Fallen {
    /// True where the base is too low or tilted too far; nowhere if both limits are 0.
    #[inline(always)]
    pub(crate) fn is_down<V: Real>(&self, base: &BodyState<V>) -> V::Mask {
        let low =
            if self.height_m > 0.0 { base.pos.z().lt(V::c(self.height_m)) } else { V::Mask::splat(false) };
        if self.tilt_deg > 0.0 {
            let upright = -projected_gravity(&base.rot).z();
            low.or(upright.lt(V::c(self.tilt_deg.to_radians().cos())))
        } else {
            low
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::Fixture;
    use paid_lanes::{Quat, Vec3};

    #[test]
    fn a_low_base_and_a_tilted_one_fail() {
        let mut fixture = Fixture::new();
        for (height, degrees, fails) in
            [(0.5, 0.0_f64, false), (0.39, 0.0, true), (0.5, 61.0, true), (0.5, -59.0, false)]
        {
            let base = &mut fixture.state.bodies[0];
            base.pos = Vec3([0.0, 0.0, height]);
            base.rot = Quat::from_roll_pitch_yaw(0.0, degrees.to_radians(), 2.0).to_mat();
            let term = Fallen { height_m: 0.4, tilt_deg: 60.0 };
            assert_eq!(term.fails(&fixture.input()), fails, "{height} {degrees}");
        }
        let low_only = Fallen { height_m: 0.4, tilt_deg: 0.0 };
        fixture.state.bodies[0].rot = Quat::from_roll_pitch_yaw(3.0, 0.0, 0.0).to_mat();
        assert!(!low_only.fails(&fixture.input()) && !Fallen::default().is_on());
    }
}
