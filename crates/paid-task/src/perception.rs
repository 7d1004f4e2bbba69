//! What the policy sees of ball and goal.

use paid_lanes::rng::Rng;
use paid_lanes::{Mask, Real, Vec3};

use crate::preset::PerceptionPreset;

/// The ball as perceived by a group.
#[derive(Clone, Debug)]
pub(crate) struct Perception<V> {
    /// Last seen ball, base frame [m].
    pub ball: Vec3<V>,
    /// Near end of the band in which the ball is seen [m].
    pub near: V,
    /// Far end of the band [m].
    pub far: V,
}

impl<V: Real> Perception<V> {
    pub(crate) fn new() -> Self {
        Self { ball: Vec3::zero(), near: V::zero(), far: V::zero() }
    }

    pub(crate) fn fields(&mut self) -> [&mut V; 5] {
        let [x, y, z] = &mut self.ball.0;
        [x, y, z, &mut self.near, &mut self.far]
    }

    /// Begins an episode in one lane with the true ball, in the base frame.
    pub(crate) fn reset_lane(
        &mut self,
        lane: usize,
        ball: [f64; 3],
        preset: &PerceptionPreset,
        rng: &mut Rng,
    ) {
        self.ball.set_lane(lane, ball);
        self.near.set_lane(lane, rng.uniform(preset.near_m[0], preset.near_m[1]));
        self.far.set_lane(lane, rng.uniform(preset.far_m[0], preset.far_m[1]));
    }

    /// Takes in the true ball, base frame: seen inside the band, else the last seen position is held.
    #[inline(always)]
    pub(crate) fn advance(&mut self, ball: Vec3<V>) {
        let distance = ball.norm();
        let seen = distance.ge(self.near).and(distance.le(self.far));
        self.ball = Vec3::select(seen, ball, self.ball);
    }
}

/// Deviation of the Gaussian noise on an object (paper, physics-guided randomization): `c_min + |v| / c_vel + d / c_dist` [m].
#[inline(always)]
pub(crate) fn deviation<V: Real>(speed: V, distance: V, preset: &PerceptionPreset) -> V {
    V::c(preset.c_min) + speed * V::c(1.0 / preset.c_vel) + distance * V::c(1.0 / preset.c_dist)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preset() -> PerceptionPreset {
        PerceptionPreset {
            blind_zone: true,
            near_m: [0.5, 0.5],
            far_m: [2.0, 2.0],
            gaussian: true,
            c_min: 0.01,
            c_vel: 50.0,
            c_dist: 100.0,
            ..crate::TaskPreset::builtin("stage2").expect("valid").observations.perception
        }
    }

    #[test]
    fn a_ball_outside_the_band_is_remembered() {
        let mut perception = Perception::<f64>::new();
        perception.reset_lane(0, [3.0, 0.0, 0.0], &preset(), &mut Rng::new(0, 0, 0));
        perception.advance(Vec3([2.5, 0.0, 0.0]));
        assert_eq!(perception.ball.0, [3.0, 0.0, 0.0]);
        perception.advance(Vec3([1.0, 0.5, -0.6]));
        assert_eq!(perception.ball.0, [1.0, 0.5, -0.6]);
        perception.advance(Vec3([0.3, 0.2, 0.0]));
        assert_eq!(perception.ball.0, [1.0, 0.5, -0.6]);
    }

    #[test]
    fn deviation_grows_with_speed_and_distance() {
        let value: f64 = deviation(2.0, 3.0, &preset());
        assert!((value - (0.01 + 0.04 + 0.03)).abs() < 1e-12);
    }
}
