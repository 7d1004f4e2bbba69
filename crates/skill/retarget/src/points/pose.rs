//! How segments are turned, from where their ends are.
//!
//! A point says nothing about a turn about the line to the next one. Hinges do: a bent knee or elbow gives the axis of its limb. A
//! straight knee takes it from the foot, a straight elbow from the trunk.

use paid_lanes::stats::quantile;
use paid_lanes::{Mat3, Quat, Vec3};

use super::sheet::Indices;

type V = Vec3<f64>;

/// Sines of a hinge's bend between which its axis takes over from the fallback.
const BENT: [f64; 2] = [0.15, 0.35];
/// A foot this near to the lowest it gets stands `[m]`.
const STANDS_M: f64 = 0.03;

/// A part of the body; sides are 0 left, 1 right.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Part {
    Hips,
    Neck,
    Hip(usize),
    Knee(usize),
    Ankle(usize),
    Toe(usize),
    Shoulder(usize),
    Elbow(usize),
    Wrist(usize),
}

/// The points of one frame; pairs are left, right.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    hips: V,
    neck: V,
    hip: [V; 2],
    knee: [V; 2],
    ankle: [V; 2],
    toe: [V; 2],
    heel: [V; 2],
    shoulder: [V; 2],
    elbow: [V; 2],
    wrist: [V; 2],
}

/// Orientations of the segments in the axes of the robot's bodies.
pub(crate) struct Turns {
    /// Hips, torso.
    pub trunk: [Quat<f64>; 2],
    /// Left, right: thigh, shin, foot.
    pub legs: [[Quat<f64>; 3]; 2],
    /// Left, right: upper arm, forearm.
    pub arms: [[Quat<f64>; 2]; 2],
}

impl Body {
    pub fn of(frame: &[[f64; 3]], indices: &Indices) -> Self {
        let part = |name: &str| {
            let list = indices.get(name)?;
            let sum = list.iter().fold(Vec3::zero(), |sum, i| sum + Vec3(frame[*i]));
            Some(sum.scale(1.0 / list.len().max(1) as f64))
        };
        let pair = |name: &str| ["left", "right"].map(|side| part(&format!("{side}_{name}")));
        // The skeleton has every part that is needed.
        let sure = |name: &str| pair(name).map(|p| p.unwrap_or(Vec3::zero()));
        let middle = |[a, b]: [V; 2]| (a + b).scale(0.5);
        let (hip, ankle, shoulder) = (sure("hip"), sure("ankle"), sure("shoulder"));
        let [left, right] = pair("heel");
        Self {
            hips: part("hips").unwrap_or(middle(hip)),
            neck: part("neck").unwrap_or(middle(shoulder)),
            heel: [left.unwrap_or(ankle[0]), right.unwrap_or(ankle[1])],
            hip,
            knee: sure("knee"),
            ankle,
            toe: sure("toe"),
            shoulder,
            elbow: sure("elbow"),
            wrist: sure("wrist"),
        }
    }

    pub fn moved(&self, by: impl Fn(V) -> V) -> Self {
        let pair = |p: [V; 2]| p.map(&by);
        Self {
            hips: by(self.hips),
            neck: by(self.neck),
            hip: pair(self.hip),
            knee: pair(self.knee),
            ankle: pair(self.ankle),
            toe: pair(self.toe),
            heel: pair(self.heel),
            shoulder: pair(self.shoulder),
            elbow: pair(self.elbow),
            wrist: pair(self.wrist),
        }
    }

    pub fn at(&self, part: Part) -> V {
        match part {
            Part::Hips => self.hips,
            Part::Neck => self.neck,
            Part::Hip(side) => self.hip[side],
            Part::Knee(side) => self.knee[side],
            Part::Ankle(side) => self.ankle[side],
            Part::Toe(side) => self.toe[side],
            Part::Shoulder(side) => self.shoulder[side],
            Part::Elbow(side) => self.elbow[side],
            Part::Wrist(side) => self.wrist[side],
        }
    }

    /// Every point.
    pub fn points(&self) -> impl Iterator<Item = V> {
        let pairs =
            [self.hip, self.knee, self.ankle, self.toe, self.heel, self.shoulder, self.elbow, self.wrist];
        pairs.into_iter().flatten().chain([self.hips, self.neck])
    }

    /// From the hips to the neck.
    pub fn trunk(&self) -> V {
        self.neck - self.hips
    }

    /// The volume of the unit vectors of toes, left and up: positive in right-handed axes.
    pub fn handedness(&self) -> f64 {
        let ahead = self.toe[0] - self.heel[0] + (self.toe[1] - self.heel[1]);
        let [ahead, left, up] = [ahead, self.hip[0] - self.hip[1], self.trunk()].map(|v| unit(v, [0.0; 3]));
        ahead.cross(left).dot(up)
    }

    /// Lengths of both legs.
    pub fn legs(&self) -> [f64; 2] {
        [0, 1].map(|s| (self.hip[s] - self.knee[s]).norm() + (self.knee[s] - self.ankle[s]).norm())
    }

    /// Sines of the bends of each side's knee and elbow.
    pub fn bends(&self) -> [[f64; 2]; 2] {
        let sine = |[a, b, c]: [V; 3]| unit(a - b, [0.0; 3]).cross(unit(b - c, [0.0; 3])).norm();
        [0, 1].map(|s| {
            [[self.hip[s], self.knee[s], self.ankle[s]], [self.shoulder[s], self.elbow[s], self.wrist[s]]]
                .map(sine)
        })
    }

    /// Where a foot points.
    fn sole(&self, side: usize) -> V {
        unit(self.toe[side] - self.heel[side], [1.0, 0.0, 0.0])
    }

    pub fn orientations(&self, slopes: [f64; 2]) -> Turns {
        let up = unit(self.trunk(), [0.0, 0.0, 1.0]);
        let across = |pair: [V; 2]| {
            let y = unit(pair[0] - pair[1], [0.0, 1.0, 0.0]);
            let z = unit(up - y.scale(up.dot(y)), [0.0, 0.0, 1.0]);
            [y.cross(z), y, z]
        };
        let (hips, torso) = (across(self.hip), across(self.shoulder));
        Turns {
            trunk: [quat(hips), quat(torso)],
            legs: [0, 1].map(|side| self.leg(side, hips, slopes[side])),
            arms: [0, 1].map(|side| self.arm(side, torso)),
        }
    }

    fn leg(&self, side: usize, hips: [V; 3], slope: f64) -> [Quat<f64>; 3] {
        let thigh = unit(self.hip[side] - self.knee[side], [0.0, 0.0, 1.0]);
        let shin = unit(self.knee[side] - self.ankle[side], [0.0, 0.0, 1.0]);
        let sole = self.sole(side);
        let carried = carry(hips[2], shin, hips[1]);
        let by_foot = blend(carried, shin.cross(sole), BENT);
        let bend = thigh.cross(shin);
        // A knee does not bend the other way: what looks like it is noise.
        let axis = if bend.dot(by_foot) > 0.0 { blend(by_foot, bend, BENT) } else { by_foot };
        let upright = |z: V| {
            let y = unit(axis - z.scale(axis.dot(z)), [0.0, 1.0, 0.0]);
            [y.cross(z), y, z]
        };
        let (thigh, shin) = (upright(thigh), upright(shin));
        let y = unit(shin[1] - sole.scale(shin[1].dot(sole)), [0.0, 1.0, 0.0]);
        let flat = Quat::from_axis_angle(y, -slope).rotate(sole);
        [quat(thigh), quat(shin), quat([flat, y, flat.cross(y)])]
    }

    fn arm(&self, side: usize, torso: [V; 3]) -> [Quat<f64>; 2] {
        let upper = unit(self.shoulder[side] - self.elbow[side], [0.0, 0.0, 1.0]);
        let forearm = unit(self.wrist[side] - self.elbow[side], [1.0, 0.0, 0.0]);
        let axis = blend(carry(torso[2], upper, torso[1]), upper.cross(forearm), BENT);
        let y = unit(axis - upper.scale(axis.dot(upper)), [0.0, 1.0, 0.0]);
        let across = unit(axis - forearm.scale(axis.dot(forearm)), [0.0, 1.0, 0.0]);
        [quat([y.cross(upper), y, upper]), quat([forearm, across, forearm.cross(across)])]
    }
}

/// In which frames a foot stands: ankle and toe are near to the lowest they get.
pub(crate) fn standing(bodies: &[Body], side: usize) -> Vec<bool> {
    let low = |height: &dyn Fn(&Body) -> f64| {
        let mut all: Vec<f64> = bodies.iter().map(height).collect();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 20).copied().unwrap_or(0.0) + STANDS_M
    };
    let (ankle, toe) = (low(&|b| b.ankle[side].z()), low(&|b| b.toe[side].z()));
    bodies.iter().map(|b| b.ankle[side].z() <= ankle && b.toe[side].z() <= toe).collect()
}

/// How far the line from heel (or ankle) to toe points down while each foot stands `[rad]`: the median. Zero for a foot that never stands.
pub(crate) fn slopes(bodies: &[Body]) -> [f64; 2] {
    [0, 1].map(|side| {
        let standing = bodies.iter().zip(standing(bodies, side)).filter(|(_, stands)| *stands);
        let mut down: Vec<f64> = standing.map(|(b, _)| (-b.sole(side).z()).clamp(-1.0, 1.0).asin()).collect();
        quantile(&mut down, 0.5).unwrap_or(0.0)
    })
}

/// `v` at length one; `other` where it has none.
fn unit(v: V, other: [f64; 3]) -> V {
    let n = v.norm();
    if n > 1e-9 { v.scale(1.0 / n) } else { Vec3(other) }
}

/// `v` turned as the shortest turn brings `from` to `to`, all of length one.
fn carry(from: V, to: V, v: V) -> V {
    let (w, axis) = (1.0 + from.dot(to), from.cross(to));
    if w < 1e-6 { v } else { Quat([w, axis.x(), axis.y(), axis.z()]).normalize().rotate(v) }
}

/// The direction of `own`, as far as it is long enough, else `fallback`.
fn blend(fallback: V, own: V, [from, to]: [f64; 2]) -> V {
    let s = ((own.norm() - from) / (to - from)).clamp(0.0, 1.0);
    let s = s * s * (3.0 - 2.0 * s);
    unit(fallback.scale(1.0 - s) + unit(own, [0.0; 3]).scale(s), fallback.0)
}

/// The orientation whose axes x, y, z are these.
fn quat([x, y, z]: [V; 3]) -> Quat<f64> {
    Mat3([x.0, y.0, z.0]).transpose().to_quat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: V, b: [f64; 3]) -> bool {
        (a - Vec3(b)).norm() < 1e-9
    }

    #[test]
    fn axes_become_their_orientation() {
        for q in [[0.9, 0.1, -0.3, 0.2], [0.1, 0.9, 0.3, -0.2], [0.1, -0.2, 0.9, 0.3], [-0.1, 0.3, 0.2, 0.9]]
        {
            let q = Quat(q).normalize();
            let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| q.rotate(Vec3(e)));
            let found = quat(axes);
            let cosine: f64 = found.0.iter().zip(q.0).map(|(a, b)| a * b).sum();
            assert!(cosine.abs() > 1.0 - 1e-12, "{found:?} {q:?}");
        }
    }

    #[test]
    fn a_bent_knee_and_a_bent_elbow_give_their_axes() {
        // A stand whose left thigh is raised straight ahead with the shin hanging down, and whose left upper arm hangs with the forearm
        // to the right: the arm is turned inward by 90 degrees.
        let pair = |left: [f64; 3], right: [f64; 3]| [Vec3(left), Vec3(right)];
        let body = Body {
            hips: Vec3([0.0, 0.0, 0.9]),
            neck: Vec3([0.0, 0.0, 1.4]),
            hip: pair([0.0, 0.1, 0.9], [0.0, -0.1, 0.9]),
            knee: pair([0.4, 0.1, 0.9], [0.0, -0.1, 0.5]),
            ankle: pair([0.4, 0.1, 0.5], [0.0, -0.1, 0.1]),
            toe: pair([0.6, 0.1, 0.5], [0.2, -0.1, 0.1]),
            heel: pair([0.4, 0.1, 0.5], [0.0, -0.1, 0.1]),
            shoulder: pair([0.0, 0.2, 1.4], [0.0, -0.2, 1.4]),
            elbow: pair([0.0, 0.2, 1.1], [0.0, -0.2, 1.1]),
            wrist: pair([0.0, -0.05, 1.1], [0.25, -0.2, 1.1]),
        };
        let turns = body.orientations([0.0; 2]);
        let axis = |q: Quat<f64>, k: usize| q.rotate(Vec3([0, 1, 2].map(|i| f64::from(u8::from(i == k)))));
        let [thigh, shin, foot] = turns.legs[0];
        // Raised: the thigh's up (toward the hip) points back, its ahead up.
        assert!(near(axis(thigh, 2), [-1.0, 0.0, 0.0]) && near(axis(thigh, 0), [0.0, 0.0, 1.0]));
        assert!(near(axis(shin, 0), [1.0, 0.0, 0.0]) && near(axis(foot, 0), [1.0, 0.0, 0.0]));
        let [upper, forearm] = turns.arms[0];
        assert!(near(axis(upper, 0), [0.0, -1.0, 0.0]) && near(axis(upper, 2), [0.0, 0.0, 1.0]));
        assert!(near(axis(forearm, 0), [0.0, -1.0, 0.0]));
        for q in turns.legs[1].into_iter().chain(turns.arms[1]).chain(turns.trunk) {
            assert!(q.0[0].abs() > 1.0 - 1e-9, "the right side stands: {q:?}");
        }
    }
}
