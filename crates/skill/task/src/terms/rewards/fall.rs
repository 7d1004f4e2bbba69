//! The penalty for a fall.

use paid_lanes::Real;

use crate::{RewardTerm, TermInput, reward_term};

reward_term! {
    /// 1 in the step in which the robot has fallen by the limits of the termination `fallen`, which ends the episode; 0 in a task without
    /// that termination.
    pub struct Fall {}
}

impl RewardTerm for Fall {
    const UNIT: &'static str = "";
    const FRAME: &'static str = "world, vertical";

    #[inline(always)]
    fn value<V: Real>(&self, input: &TermInput<'_, V>) -> V {
        let fallen = input.config.preset.terminations.fallen.is_down(&input.state.bodies[0]);
        V::select(fallen, V::one(), V::zero())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use paid_lanes::{Quat, Vec3};

    #[test]
    fn a_fall_counts_once_by_the_terminations_limits() {
        let mut fixture = Fixture::new();
        let tilted = Quat::from_roll_pitch_yaw(0.0, 61.0_f64.to_radians(), 0.4).to_mat();
        fixture.state.bodies[0].pos = Vec3([0.0, 0.0, 0.5]);
        fixture.state.bodies[0].rot = tilted;
        close(Fall::default().value(&fixture.input()), 0.0);
        fixture.config.preset.terminations.fallen.tilt_deg = 60.0;
        close(Fall::default().value(&fixture.input()), 1.0);
        fixture.config.preset.terminations.fallen.tilt_deg = 62.0;
        close(Fall::default().value(&fixture.input()), 0.0);
        fixture.config.preset.terminations.fallen.height_m = 0.51;
        close(Fall::default().value(&fixture.input()), 1.0);
    }
}
