//! The reference frame of each lane of a group.

use paid_lanes::{MAX_LANES, Mat3, Quat, Real, Vec3, load_f32};
use paid_play::{FrameLayout, ReferenceLibrary};
use paid_policy::{Pose, ReferenceView};

use crate::references::anchoring::LaneAnchoring;

/// One packed frame a lane, see [`FrameLayout`].
#[derive(Clone, Debug)]
pub(crate) struct Reference<V> {
    layout: FrameLayout,
    values: Vec<V>,
    /// The anchor's angular velocity in the clip's axes, where those are not the world's `[rad/s]`.
    in_clip: Option<Vec3<V>>,
}

impl<V: Real> Reference<V> {
    pub(crate) fn new(layout: FrameLayout) -> Self {
        Self { layout, values: vec![V::zero(); layout.len()], in_clip: None }
    }

    /// Loads frame `frames[lane]` of motion `motions[lane]` into every lane.
    #[inline(always)]
    pub(crate) fn gather(&mut self, library: &ReferenceLibrary, motions: &[usize], frames: &[usize]) {
        let len = self.layout.len();
        let mut rows = [library.frame(motions[0], frames[0]); MAX_LANES];
        for lane in 1..V::LANES {
            rows[lane] = library.frame(motions[lane], frames[lane]);
        }
        for lane in 0..V::LANES {
            rows[lane] = &rows[lane][..len];
        }
        self.in_clip = None;
        let values = &mut self.values[..len];
        for k in 0..len {
            let mut lanes = [0.0; MAX_LANES];
            for lane in 0..V::LANES {
                lanes[lane] = rows[lane][k];
            }
            values[k] = load_f32::<V>(&lanes);
        }
    }

    /// Moves the loaded frames over the ground. What a policy observes stays in the clip's axes, since that is what it was trained on
    /// and a robot knows no others.
    #[inline(always)]
    pub(crate) fn move_by(&mut self, anchoring: &LaneAnchoring<V>, anchor: usize) {
        self.in_clip = Some(self.ang_vel(anchor));
        for body in 0..self.layout.bodies {
            let at = 2 * self.layout.joints + FrameLayout::BODY * body;
            let [pos, com_vel, ang_vel] = [self.pos(body), self.com_vel(body), self.ang_vel(body)];
            let q = &self.values[at + 3..at + 7];
            let rot = anchoring.rotation(Quat([q[0], q[1], q[2], q[3]])).0;
            let parts = [
                &anchoring.point(pos).0[..],
                &rot,
                &anchoring.vector(com_vel).0,
                &anchoring.vector(ang_vel).0,
            ];
            let mut to = at;
            for part in parts {
                self.values[to..to + part.len()].copy_from_slice(part);
                to += part.len();
            }
        }
    }

    /// What observation terms read of it.
    #[inline(always)]
    pub(crate) fn view(&self, anchor: usize) -> ReferenceView<'_, V> {
        let (joint_pos, rest) = self.values.split_at(self.layout.joints);
        ReferenceView {
            joint_pos,
            joint_vel: &rest[..self.layout.joints],
            anchor: Pose { pos: self.pos(anchor), rot: self.rot(anchor) },
            anchor_ang_vel: self.in_clip.unwrap_or_else(|| self.ang_vel(anchor)),
        }
    }

    /// Joint angle of policy joint `j` `[rad]`.
    #[inline(always)]
    pub(crate) fn joint_pos(&self, j: usize) -> V {
        self.values[j]
    }
    /// Joint velocity of policy joint `j` `[rad/s]`.
    #[inline(always)]
    pub(crate) fn joint_vel(&self, j: usize) -> V {
        self.values[self.layout.joints + j]
    }
    #[inline(always)]
    fn vec(&self, body: usize, offset: usize) -> Vec3<V> {
        let at = 2 * self.layout.joints + FrameLayout::BODY * body + offset;
        Vec3([self.values[at], self.values[at + 1], self.values[at + 2]])
    }
    /// Position of a followed body, world `[m]`.
    #[inline(always)]
    pub(crate) fn pos(&self, body: usize) -> Vec3<V> {
        self.vec(body, 0)
    }
    /// Orientation of a followed body.
    #[inline(always)]
    pub(crate) fn rot(&self, body: usize) -> Mat3<V> {
        let at = 2 * self.layout.joints + FrameLayout::BODY * body + 3;
        let q = &self.values[at..at + 4];
        Quat([q[0], q[1], q[2], q[3]]).to_mat()
    }
    /// Velocity of a followed body's center of mass, world `[m/s]`.
    #[inline(always)]
    pub(crate) fn com_vel(&self, body: usize) -> Vec3<V> {
        self.vec(body, 7)
    }
    /// Angular velocity of a followed body, world `[rad/s]`.
    #[inline(always)]
    pub(crate) fn ang_vel(&self, body: usize) -> Vec3<V> {
        self.vec(body, 10)
    }
}
