//! The ball while it is out of sight.

use paid_lanes::rng::Rng;
use paid_lanes::{Mask, Real, Vec3};
use paid_policy::Pose;

use crate::preset::{MemoryFrame, PerceptionPreset};

impl MemoryFrame {
    /// A point of the base frame `[m]`, as it is remembered.
    #[inline(always)]
    pub(crate) fn keep<V: Real>(self, base: &Pose<V>, point: Vec3<V>) -> Vec3<V> {
        match self {
            Self::Base => point,
            Self::World => base.point_in_world(point),
        }
    }

    /// A remembered point in the base frame of now `[m]`.
    #[inline(always)]
    pub(crate) fn recall<V: Real>(self, base: &Pose<V>, kept: Vec3<V>) -> Vec3<V> {
        match self {
            Self::Base => kept,
            Self::World => base.point_in_body(kept),
        }
    }
}

/// The ball as a group remembers it.
#[derive(Clone, Debug)]
pub(crate) struct BallMemory<V> {
    /// Last seen ball in the preset's [`MemoryFrame`] `[m]`.
    ball: Vec3<V>,
    /// Near end of the band in which the ball is seen `[m]`.
    pub near: V,
    /// Far end of the band `[m]`.
    pub far: V,
}

impl<V: Real> BallMemory<V> {
    pub(crate) fn new() -> Self {
        Self { ball: Vec3::zero(), near: V::zero(), far: V::zero() }
    }

    pub(crate) fn fields(&mut self) -> [&mut V; 5] {
        let [x, y, z] = &mut self.ball.0;
        [x, y, z, &mut self.near, &mut self.far]
    }

    /// Begins an episode in one lane with the true ball, in the preset's frame.
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

    /// Takes in the true ball, base frame `[m]`: seen inside the band, else the last seen position stays.
    #[inline(always)]
    pub(crate) fn advance(&mut self, ball: Vec3<V>, base: &Pose<V>, frame: MemoryFrame) {
        let distance = ball.norm();
        let seen = distance.ge(self.near).and(distance.le(self.far));
        self.ball = Vec3::select(seen, frame.keep(base, ball), self.ball);
    }

    /// The remembered ball in the base frame `[m]`.
    pub(crate) fn ball(&self, base: &Pose<V>, frame: MemoryFrame) -> Vec3<V> {
        frame.recall(base, self.ball)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::Quat;

    fn memory() -> BallMemory<f64> {
        let preset = PerceptionPreset {
            near_m: [0.5, 0.5],
            far_m: [2.0, 2.0],
            ..crate::TaskPreset::builtin("paper_stage2").expect("valid").observations.perception
        };
        let mut memory = BallMemory::new();
        memory.reset_lane(0, [3.0, 0.0, 0.0], &preset, &mut Rng::new(0, 0, 0));
        memory
    }

    #[test]
    fn a_ball_outside_the_band_is_remembered() {
        let (mut memory, base, frame) = (memory(), Pose::identity(), MemoryFrame::Base);
        memory.advance(Vec3([2.5, 0.0, 0.0]), &base, frame);
        assert_eq!(memory.ball(&base, frame).0, [3.0, 0.0, 0.0]);
        memory.advance(Vec3([1.0, 0.5, -0.6]), &base, frame);
        assert_eq!(memory.ball(&base, frame).0, [1.0, 0.5, -0.6]);
        memory.advance(Vec3([0.3, 0.2, 0.0]), &base, frame);
        assert_eq!(memory.ball(&base, frame).0, [1.0, 0.5, -0.6]);
    }

    #[test]
    fn a_robot_that_walks_past_leaves_the_ball_behind_in_the_world_only() {
        let ahead = Vec3([1.0, 0.0, -0.6]);
        // Three steps on and a quarter turn to the left.
        let later = Pose {
            pos: Vec3([3.0, 0.0, 0.0]),
            rot: Quat::from_roll_pitch_yaw(0.0, 0.0, std::f64::consts::FRAC_PI_2).to_mat(),
        };
        for (frame, expected) in [(MemoryFrame::Base, ahead.0), (MemoryFrame::World, [0.0, 2.0, -0.6])] {
            let mut memory = memory();
            memory.advance(ahead, &Pose::identity(), frame);
            // Out of the band by now: what was seen stays.
            memory.advance(Vec3([0.1, 0.0, 0.0]), &later, frame);
            let seen = memory.ball(&later, frame).0;
            assert!((0..3).all(|k| (seen[k] - expected[k]).abs() < 1e-12), "{frame:?}: {seen:?}");
        }
    }
}
