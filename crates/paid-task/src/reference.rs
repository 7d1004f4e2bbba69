//! The reference frame of each lane of a group.

use paid_lanes::{MAX_LANES, Mat3, Quat, Real, Vec3, load_f32};
use paid_policy::{Pose, ReferenceView};

use crate::{FrameLayout, ReferenceLibrary};

/// One packed frame a lane, see [`FrameLayout`].
#[derive(Clone, Debug)]
pub(crate) struct Reference<V> {
    layout: FrameLayout,
    values: Vec<V>,
}

impl<V: Real> Reference<V> {
    pub(crate) fn new(layout: FrameLayout) -> Self {
        Self { layout, values: vec![V::zero(); layout.len()] }
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
        let values = &mut self.values[..len];
        for k in 0..len {
            let mut lanes = [0.0; MAX_LANES];
            for lane in 0..V::LANES {
                lanes[lane] = rows[lane][k];
            }
            values[k] = load_f32::<V>(&lanes);
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
            anchor_ang_vel: self.ang_vel(anchor),
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
