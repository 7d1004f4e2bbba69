//! A reference that begins where the robot stands: clips are moved over the ground, robots are not.

use paid_lanes::{Quat, Real, Vec3};
use paid_play::{MotionFacts, turned};
use serde::{Deserialize, Serialize};

/// Where a motion begins: a turn about the vertical and a shift over the ground of everything in the clip.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Anchoring {
    /// Turn about the world's vertical `[rad]`.
    pub turn: f64,
    /// Shift after the turn `[m]`.
    pub shift: [f64; 2],
}

impl Anchoring {
    /// The one by which a motion begins with its anchor above `place` `[m]` and with this heading `[rad]`.
    pub(crate) fn new(facts: &MotionFacts, place: [f64; 2], heading: f64) -> Self {
        let turn = heading - facts.heading;
        let start = turned(facts.start_xy, turn);
        Self { turn, shift: [place[0] - start[0], place[1] - start[1]] }
    }

    /// A point of the clip on the ground, in the world `[m]`.
    pub(crate) fn point(&self, xy: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned(xy, self.turn);
        [x + self.shift[0], y + self.shift[1]]
    }
}

/// The same for every lane of a group.
#[derive(Clone, Debug)]
pub(crate) struct LaneAnchoring<V> {
    cos: V,
    sin: V,
    /// Quaternion of the turn: w and z.
    half: [V; 2],
    shift: [V; 2],
}

impl<V: Real> LaneAnchoring<V> {
    /// Leaves every clip where it is.
    pub(crate) fn none() -> Self {
        let (zero, one) = (V::zero(), V::one());
        Self { cos: one, sin: zero, half: [one, zero], shift: [zero; 2] }
    }

    pub(crate) fn set_lane(&mut self, lane: usize, anchoring: Option<&Anchoring>) {
        let Anchoring { turn, shift } =
            anchoring.copied().unwrap_or(Anchoring { turn: 0.0, shift: [0.0; 2] });
        self.cos.set_lane(lane, turn.cos());
        self.sin.set_lane(lane, turn.sin());
        self.half[0].set_lane(lane, (0.5 * turn).cos());
        self.half[1].set_lane(lane, (0.5 * turn).sin());
        for (to, from) in self.shift.iter_mut().zip(shift) {
            to.set_lane(lane, from);
        }
    }

    /// A vector of the clip in the world.
    #[inline(always)]
    pub(crate) fn vector(&self, v: Vec3<V>) -> Vec3<V> {
        Vec3([self.cos * v.x() - self.sin * v.y(), self.sin * v.x() + self.cos * v.y(), v.z()])
    }

    /// A point of the clip in the world `[m]`.
    #[inline(always)]
    pub(crate) fn point(&self, p: Vec3<V>) -> Vec3<V> {
        self.vector(p) + Vec3([self.shift[0], self.shift[1], V::zero()])
    }

    /// An orientation of the clip in the world.
    #[inline(always)]
    pub(crate) fn rotation(&self, q: Quat<V>) -> Quat<V> {
        let [w, z] = self.half;
        Quat([w, V::zero(), V::zero(), z]).mul(q)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::FRAC_PI_2;

    use super::*;

    #[test]
    fn a_motion_that_looks_along_y_begins_along_x_elsewhere() {
        let facts = MotionFacts {
            name: "m".into(),
            frames: 10,
            kick_foot: 1,
            strike_frame: 5,
            contact_frame: 5,
            strike_speed: 1.0,
            start_xy: [1.0, 2.0],
            base_xy: [1.0, 2.0],
            heading: FRAC_PI_2,
            displacement: [0.0, 1.0],
        };
        let anchoring = Anchoring::new(&facts, [5.0, -3.0], 0.0);
        let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12);
        assert!(near(&anchoring.point([1.0, 2.0]), &[5.0, -3.0]));
        // A meter ahead and half a meter to the left.
        assert!(near(&anchoring.point([0.5, 3.0]), &[6.0, -2.5]));
        let mut lanes = LaneAnchoring::<f64>::none();
        assert_eq!(lanes.point(Vec3([1.0, 2.0, 3.0])).0, [1.0, 2.0, 3.0]);
        lanes.set_lane(0, Some(&anchoring));
        assert!(near(&lanes.point(Vec3([0.5, 3.0, 0.7])).0, &[6.0, -2.5, 0.7]));
        assert!(near(&lanes.vector(Vec3([0.0, 2.0, 0.1])).0, &[2.0, 0.0, 0.1]));
        let along = lanes.rotation(Quat::from_roll_pitch_yaw(0.0, 0.0, FRAC_PI_2));
        assert!(near(&along.0, &[1.0, 0.0, 0.0, 0.0]), "{along:?}");
    }
}
