//! Where a bone is in its parent's axes: what the writers of human motion need.

use std::f64::consts::FRAC_PI_2;

use paid_lanes::{Quat, Vec3};

use crate::HumanMotion;
use crate::skeleton::about;

/// Meters of a unit of length in the texts that are written: the centimeter, as in nearly every BVH.
pub const TEXT_UNIT_M: f64 = 0.01;
/// A place that changes by less over a motion is constant `[cm]`.
const CONSTANT_CM: f64 = 1e-5;

/// The bones that hang on `parent`; the roots with `None`.
pub(crate) fn children(motion: &HumanMotion, parent: Option<usize>) -> impl Iterator<Item = usize> + '_ {
    let bones = motion.skeleton.bones.iter().enumerate();
    bones.filter(move |(_, bone)| bone.parent == parent).map(|(i, _)| i)
}

/// Place `[cm]` and turn of bone `i` in its parent's axes at frame `t`; a root's in the file's world, y up.
pub(crate) fn local_cm(motion: &HumanMotion, i: usize, t: usize) -> ([f64; 3], Quat<f64>) {
    let (pos, quat) = (motion.pos(t), motion.quat(t));
    let (from, axes) = match motion.skeleton.bones[i].parent {
        Some(p) => (Vec3(pos[p]), Quat(quat[p])),
        // The file's world in ours, see `HumanMotion::from_channels`.
        None => (Vec3([0.0; 3]), about(0, FRAC_PI_2)),
    };
    let back = axes.conj();
    let place = back.rotate(Vec3(pos[i]) - from).scale(1.0 / TEXT_UNIT_M);
    (place.0, back.mul(Quat(quat[i])).normalize())
}

/// The place `[cm]` of the first of `frames` frames, if it is that of all.
pub(crate) fn constant_cm(frames: usize, place: impl Fn(usize) -> [f64; 3]) -> Option<[f64; 3]> {
    let first = place(0);
    let still = |t| (Vec3(place(t)) - Vec3(first)).norm() <= CONSTANT_CM;
    (1..frames).all(still).then_some(first)
}

/// True if bone `i` keeps its parent's axes in every frame.
pub(crate) fn never_turns(motion: &HumanMotion, i: usize) -> bool {
    (0..motion.frames).all(|t| {
        let [w, ..] = local_cm(motion, i, t).1.0;
        w.abs() > 1.0 - 1e-14
    })
}

/// The angles `[rad]` about the coordinate axes `i`, `j`, `k`, all different, whose turns, multiplied in this order, are `q`.
pub(crate) fn turn_angles(q: Quat<f64>, [i, j, k]: [usize; 3]) -> [f64; 3] {
    let m = q.to_mat().0;
    let sign = if (i + 1) % 3 == j { 1.0 } else { -1.0 };
    let cos_middle = m[i][i].hypot(m[i][j]);
    let middle = (sign * m[i][k]).atan2(cos_middle);
    if cos_middle < 1e-9 {
        // Only the sum or difference of the other two is determined.
        return [(sign * m[k][j]).atan2(m[j][j]), middle, 0.0];
    }
    [(-sign * m[j][k]).atan2(m[k][k]), middle, (-sign * m[i][j]).atan2(m[i][i])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_order_of_axes_gives_its_angles_back() {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [1, 0, 2], [2, 1, 0]];
        for order in orders {
            for angles in [[0.3, -1.2, 2.9], [-2.0, 1.5, -0.4], [0.7, FRAC_PI_2, 0.0]] {
                let turn = |k: usize| about(order[k], angles[k]);
                let found = turn_angles(turn(0).mul(turn(1)).mul(turn(2)), order);
                for (a, b) in found.iter().zip(angles) {
                    assert!((a - b).abs() < 1e-7, "{order:?}: {found:?}, {angles:?}");
                }
            }
        }
    }
}
