//! A skeleton of any file format, and where its bones are.

use paid_lanes::{Quat, Vec3};

/// More poses of bones than this are no motion: 75 minutes of 62 bones at 120 Hz. Bones without channels cost no byte of a frame, so that
/// a small file could ask for all memory.
const MOST_POSES: usize = 1 << 25;

/// A bone. Lengths are in the file's unit, axes are the file's.
#[derive(Clone, Debug, PartialEq)]
pub struct Bone {
    /// Its name; unique within a skeleton.
    pub name: String,
    /// The bone that it hangs on; comes earlier in the skeleton.
    pub parent: Option<usize>,
    /// Where it turns, from its parent's point, in the parent's axes (BVH's offset).
    pub head: [f64; 3],
    /// Its point, from where it turns, in its own axes (ASF: direction times length; BVH: zero).
    pub tail: [f64; 3],
    /// The axes that its angles are about, in its own rest axes (ASF), unit, w, x, y, z.
    pub axes: [f64; 4],
    /// Rotations in the order of multiplication: axis (0 to 2), index of the channel that holds the angle `[rad]`.
    pub turns: Vec<(usize, usize)>,
    /// Channels that replace the coordinates of `head`.
    pub moves: [Option<usize>; 3],
}

impl Bone {
    /// A bone without length and channels.
    pub fn new(name: impl Into<String>, parent: Option<usize>) -> Self {
        Self {
            name: name.into(),
            parent,
            head: [0.0; 3],
            tail: [0.0; 3],
            axes: [1.0, 0.0, 0.0, 0.0],
            turns: Vec::new(),
            moves: [None; 3],
        }
    }
}

/// Pose of a bone in the file's world.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BonePose {
    /// Its point: where it turns (BVH) or where it ends (ASF).
    pub pos: [f64; 3],
    /// Its orientation, unit, w, x, y, z.
    pub quat: [f64; 4],
}

/// Bones, a parent before its children.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Skeleton {
    /// The bones.
    pub bones: Vec<Bone>,
    /// Number of channels of a frame.
    pub channels: usize,
}

/// The rotation about a coordinate axis `[rad]`.
pub(crate) fn about(axis: usize, angle: f64) -> Quat<f64> {
    let mut unit = [0.0; 3];
    unit[axis] = 1.0;
    Quat::from_axis_angle(Vec3(unit), angle)
}

impl Skeleton {
    /// Index of a bone by name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.bones.iter().position(|b| b.name == name)
    }

    /// How many frames a motion of it may have.
    pub(crate) fn most_frames(&self) -> usize {
        MOST_POSES / self.bones.len().max(1)
    }

    /// Poses of all bones from a frame's channels (lengths in the file's unit, angles in rad).
    ///
    /// # Panics
    /// If `frame` has fewer than [`Skeleton::channels`] values.
    pub fn forward(&self, frame: &[f64]) -> Vec<BonePose> {
        let mut poses: Vec<BonePose> = Vec::with_capacity(self.bones.len());
        for bone in &self.bones {
            let mut head = bone.head;
            for (x, channel) in head.iter_mut().zip(bone.moves) {
                *x = channel.map_or(*x, |c| frame[c]);
            }
            let (at, up) = bone
                .parent
                .map_or((Vec3::zero(), Quat::identity()), |p| (Vec3(poses[p].pos), Quat(poses[p].quat)));
            let axes = Quat(bone.axes);
            let turn = bone.turns.iter().fold(axes, |q, &(axis, channel)| q.mul(about(axis, frame[channel])));
            let quat = up.mul(turn).mul(axes.conj()).normalize();
            let pos = at + up.rotate(Vec3(head)) + quat.rotate(Vec3(bone.tail));
            poses.push(BonePose { pos: pos.0, quat: quat.0 });
        }
        poses
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn a_bent_arm_ends_where_it_must() {
        // An upper arm that turns about z, and a forearm of length 2 that turns about its own x after axes turned by 90 degrees
        // about z: so about y.
        let mut arm = Bone::new("arm", None);
        arm.moves = [Some(0), None, None];
        arm.turns = vec![(2, 1)];
        let mut forearm = Bone::new("forearm", Some(0));
        forearm.head = [1.0, 0.0, 0.0];
        forearm.tail = [2.0, 0.0, 0.0];
        forearm.axes = about(2, FRAC_PI_2).0;
        forearm.turns = vec![(0, 2)];
        let skeleton = Skeleton { bones: vec![arm, forearm], channels: 3 };
        let poses = skeleton.forward(&[5.0, FRAC_PI_2, FRAC_PI_2]);
        // The arm points along y from (5, 0, 0); the forearm, turned by 90 degrees about the arm's y, points down.
        for (found, expected) in poses[1].pos.iter().zip([5.0, 1.0, -2.0]) {
            assert!((found - expected).abs() < 1e-12, "{:?}", poses[1]);
        }
    }
}
