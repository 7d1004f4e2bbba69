//! What a policy would see and do in a mirrored world.
//!
//! A robot whose left and right are alike can do everything mirrored. In the mirror image of a state (in the x-z plane of the world)
//! each number of the observation is one of the numbers of the state's observation, up to its sign; the same holds for actions.

use paid_lanes::Real;

use crate::element::{Element, Lanewise};
use crate::matrix::{Mat, MatMut};
use crate::normalizer::Normalizer;
use crate::observation::{ObservationId, Shape};

/// Signs of a vector's mirrored components.
const POLAR: [f32; 3] = [1.0, -1.0, 1.0];
/// Signs of a mirrored angular velocity's components.
const AXIAL: [f32; 3] = [-1.0, 1.0, -1.0];
/// Signs of the first two columns of a mirrored rotation, row by row: with S = diag(1, -1, 1) it is S R S.
const ROTATION: [f32; 6] = [1.0, -1.0, -1.0, 1.0, 1.0, -1.0];

/// Which joints and bodies are each other's image.
#[derive(Clone, Debug, PartialEq)]
pub struct Sides {
    /// For each joint of the policy its image and the sign of its angle there.
    pub joints: Vec<(usize, f64)>,
    /// For each tracked body its image.
    pub bodies: Vec<usize>,
}

/// A number of the mirrored vector: one of the vector's numbers, times a factor, plus a constant.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Row {
    from: usize,
    gain: f32,
    offset: f32,
}

/// How a vector reads in a mirrored world.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirror {
    rows: Vec<Row>,
}

/// How a policy's input and output read in a mirrored world.
#[derive(Clone, Debug, PartialEq)]
pub struct Mirrors {
    /// The policy's observation, before normalization.
    pub observation: Mirror,
    /// Actions.
    pub action: Mirror,
}

impl Mirrors {
    /// Of a policy that observes these terms and gives an action for each joint.
    pub fn new(sides: &Sides, terms: &[ObservationId]) -> Self {
        Self { observation: Mirror::of_observation(terms, sides), action: Mirror::of_joints(sides) }
    }
}

impl Mirror {
    /// Of a number for each joint: angles, velocities, actions.
    pub fn of_joints(sides: &Sides) -> Self {
        let row = |&(from, sign): &(usize, f64)| Row { from, gain: sign as f32, offset: 0.0 };
        Self { rows: sides.joints.iter().map(row).collect() }
    }

    /// Of the observation that has these terms.
    pub fn of_observation(terms: &[ObservationId], sides: &Sides) -> Self {
        let mut rows = Vec::new();
        for id in terms {
            let (info, first) = (id.info(), rows.len());
            let blocks = |images: &[usize], signs: &[f32]| -> Vec<Row> {
                let of_block = |&image: &usize| {
                    let row =
                        move |(k, &gain)| Row { from: first + image * signs.len() + k, gain, offset: 0.0 };
                    signs.iter().enumerate().map(row).collect::<Vec<_>>()
                };
                images.iter().flat_map(of_block).collect()
            };
            let vector = if info.axial { &AXIAL } else { &POLAR };
            let scalar = if info.axial { -1.0 } else { 1.0 };
            rows.extend(match info.shape {
                Shape::Joints => {
                    let shifted = |row: Row| Row { from: first + row.from, ..row };
                    Self::of_joints(sides).rows.into_iter().map(shifted).collect()
                }
                Shape::Scalar => blocks(&[0], &[scalar]),
                Shape::Vector => blocks(&[0], vector),
                Shape::Rotation => blocks(&[0], &ROTATION),
                Shape::BodyVectors => blocks(&sides.bodies, vector),
                Shape::BodyRotations => blocks(&sides.bodies, &ROTATION),
            });
        }
        Self { rows }
    }

    /// The same for vectors that the normalizer has been applied to.
    ///
    /// # Panics
    /// If the normalizer is for vectors of another length.
    #[must_use]
    pub fn normalized(&self, normalizer: &Normalizer) -> Self {
        let (mean, inv_std) = (normalizer.mean(), normalizer.inv_std());
        assert_eq!(mean.len(), self.rows.len(), "features");
        let row = |(k, row): (usize, &Row)| Row {
            from: row.from,
            gain: row.gain * inv_std[k] / inv_std[row.from],
            offset: (row.offset + row.gain * mean[row.from] - mean[k]) * inv_std[k],
        };
        Self { rows: self.rows.iter().enumerate().map(row).collect() }
    }

    /// Number of numbers.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// True for vectors without numbers.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// For each number where it comes from, and its sign.
    pub fn signs(&self) -> impl Iterator<Item = (usize, f32)> {
        self.rows.iter().map(|row| (row.from, row.gain.signum()))
    }

    /// Mirrors the marked columns of `x` `[features, columns]` in place; `room` is for a copy of it.
    ///
    /// # Panics
    /// If `x` has other features.
    pub fn apply_to_marked(&self, x: &mut [f32], marked: &[bool], room: &mut Vec<f32>) {
        let n = marked.len();
        assert_eq!(x.len(), self.len() * n, "{} rows of {n} columns", self.len());
        room.clear();
        room.extend_from_slice(x);
        f32::launch(Marked { rows: &self.rows, from: room, to: x, marked });
    }

    /// Mirrors each column of `x` `[features, n]` into `out`.
    ///
    /// # Panics
    /// If the shapes are not equal or have other features.
    pub fn apply(&self, x: Mat<'_, f32>, out: MatMut<'_, f32>) {
        assert!(
            x.rows() == self.len() && out.rows() == x.rows() && out.cols() == x.cols(),
            "[{}, {}] from [{}, {}] by {} rows",
            out.rows(),
            out.cols(),
            x.rows(),
            x.cols(),
            self.len()
        );
        f32::launch(Whole { rows: &self.rows, from: x, to: out });
    }
}

/// [`Mirror::apply`]; a kernel, because a fused product outside of one is a call for each number.
struct Whole<'a> {
    rows: &'a [Row],
    from: Mat<'a, f32>,
    to: MatMut<'a, f32>,
}

impl Lanewise<f32> for Whole<'_> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = f32>>(mut self) {
        for (k, row) in self.rows.iter().enumerate() {
            for (to, from) in self.to.row(k).iter_mut().zip(self.from.row(row.from)) {
                *to = from.mul_add(row.gain, row.offset);
            }
        }
    }
}

/// [`Mirror::apply_to_marked`], `from` being a copy of `to`.
struct Marked<'a> {
    rows: &'a [Row],
    from: &'a [f32],
    to: &'a mut [f32],
    marked: &'a [bool],
}

impl Lanewise<f32> for Marked<'_> {
    type Output = ();
    #[inline(always)]
    fn run<V: Real<Scalar = f32>>(self) {
        let n = self.marked.len();
        for (to, row) in self.to.chunks_exact_mut(n.max(1)).zip(self.rows) {
            let from = &self.from[row.from * n..][..n];
            for ((to, from), marked) in to.iter_mut().zip(from).zip(self.marked) {
                *to = if *marked { from.mul_add(row.gain, row.offset) } else { *to };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::normalizer::Moments;
    use crate::observation::{ObservationId, observe};
    use crate::{Pose, PrivilegedView, ReferenceView, RobotView, SceneView, Views};
    use paid_lanes::{Mat3, Quat, Vec3};

    fn polar(v: Vec3<f64>) -> Vec3<f64> {
        Vec3([v.0[0], -v.0[1], v.0[2]])
    }
    fn axial(v: Vec3<f64>) -> Vec3<f64> {
        Vec3([-v.0[0], v.0[1], -v.0[2]])
    }
    fn turned(m: Mat3<f64>) -> Mat3<f64> {
        let s = [1.0, -1.0, 1.0];
        Mat3([0, 1, 2].map(|i| [0, 1, 2].map(|j| s[i] * s[j] * m.0[i][j])))
    }
    fn posed(pose: Pose<f64>) -> Pose<f64> {
        Pose { pos: polar(pose.pos), rot: turned(pose.rot) }
    }
    fn swapped(sides: &Sides, x: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; x.len()];
        for (value, &(image, sign)) in x.iter().zip(&sides.joints) {
            out[image] = sign * value;
        }
        out
    }
    fn column(mirror: &Mirror, x: &[f64]) -> Vec<f32> {
        let x: Vec<f32> = x.iter().map(|&x| x as f32).collect();
        let mut out = vec![0.0; x.len()];
        mirror.apply(Mat::new(&x, x.len(), 1, 1), MatMut::new(&mut out, x.len(), 1, 1));
        out
    }

    /// Three joints and three bodies: a pair and one in the middle.
    fn sides() -> Sides {
        Sides { joints: vec![(1, -1.0), (0, -1.0), (2, 1.0)], bodies: vec![0, 2, 1] }
    }

    #[test]
    fn every_term_of_a_mirrored_world_is_the_mirrored_term() {
        let sides = sides();
        let pose = |k: f64| Pose {
            pos: Vec3([0.3 * k, 0.7 - k, 1.0 + 0.1 * k]),
            rot: Quat::from_roll_pitch_yaw(0.3 + k, -0.4 * k, 0.9 - 0.5 * k).to_mat(),
        };
        let bodies = [pose(0.0), pose(1.0), pose(2.0)];
        let joints = [[0.1, 0.2, 0.3], [1.1, -1.2, 1.3], [2.1, 2.2, -2.3], [3.1, 3.2, 3.3], [4.1, -4.2, 4.3]];
        let (images, images_of_bodies) =
            (joints.map(|x| swapped(&sides, &x)), [bodies[0], bodies[2], bodies[1]].map(posed));
        let (gyro, turning, velocity) =
            (Vec3([0.1, 0.2, 0.3]), Vec3([0.4, -0.5, 0.6]), Vec3([0.7, 0.8, 0.9]));
        let scene = [[1.1, 1.2, -0.6], [2.1, -2.2, -0.7], [5.1, 5.2, -0.5]].map(Vec3);
        let views = Views {
            robot: RobotView {
                base_rot: pose(3.0).rot,
                base_ang_vel: gyro,
                joint_pos_rel: &joints[0],
                joint_vel: &joints[1],
                last_action: &joints[2],
            },
            privileged: Some(PrivilegedView { base_lin_vel: velocity, anchor: pose(4.0), bodies: &bodies }),
            reference: Some(ReferenceView {
                joint_pos: &joints[3],
                joint_vel: &joints[4],
                anchor: pose(5.0),
                anchor_ang_vel: turning,
            }),
            scene: Some(SceneView { ball: scene[0], ball_at_strike: scene[1], goal: scene[2] }),
        };
        let image = Views {
            robot: RobotView {
                base_rot: turned(pose(3.0).rot),
                base_ang_vel: axial(gyro),
                joint_pos_rel: &images[0],
                joint_vel: &images[1],
                last_action: &images[2],
            },
            privileged: Some(PrivilegedView {
                base_lin_vel: polar(velocity),
                anchor: posed(pose(4.0)),
                bodies: &images_of_bodies,
            }),
            reference: Some(ReferenceView {
                joint_pos: &images[3],
                joint_vel: &images[4],
                anchor: posed(pose(5.0)),
                anchor_ang_vel: axial(turning),
            }),
            scene: Some(SceneView {
                ball: polar(scene[0]),
                ball_at_strike: polar(scene[1]),
                goal: polar(scene[2]),
            }),
        };
        for id in ObservationId::BUILTIN {
            let (mut seen, mut seen_there) = (Vec::new(), Vec::new());
            observe(&[id], &views, &mut seen);
            observe(&[id], &image, &mut seen_there);
            let mirrored = column(&Mirror::of_observation(&[id], &sides), &seen);
            for (k, (a, b)) in mirrored.iter().zip(&seen_there).enumerate() {
                assert!((f64::from(*a) - b).abs() < 1e-6, "{} {k}: {a} {b}", id.name());
            }
        }
    }

    #[test]
    fn terms_of_a_list_are_mirrored_each_in_its_place() {
        let list = [ObservationId::BallPos, ObservationId::JointVel, ObservationId::BaseAngVel];
        let mirror = Mirror::of_observation(&list, &sides());
        let x = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0];
        assert_eq!(column(&mirror, &x), [1.0, -2.0, 3.0, -5.0, -4.0, 6.0, -7.0, 8.0, -9.0]);
    }

    #[test]
    fn a_normalized_vector_is_mirrored_as_if_it_were_not() {
        let mirror = Mirror::of_joints(&sides());
        let normalizer = Normalizer::from_moments(Moments {
            count: 4.0,
            mean: vec![1.0, -2.0, 3.0],
            m2: vec![4.0, 16.0, 36.0],
        });
        let apply = |x: &[f64]| {
            let x: Vec<f32> = x.iter().map(|&x| x as f32).collect();
            let mut out = vec![0.0; 3];
            normalizer.apply(Mat::new(&x, 3, 1, 1), MatMut::new(&mut out, 3, 1, 1), None);
            out.iter().map(|&x| f64::from(x)).collect::<Vec<_>>()
        };
        let x = [0.5, 0.25, -1.0];
        let there = apply(&column(&mirror, &x).iter().map(|&x| f64::from(x)).collect::<Vec<_>>());
        let mirrored = column(&mirror.normalized(&normalizer), &apply(&x));
        for (a, b) in mirrored.iter().zip(&there) {
            assert!((f64::from(*a) - b).abs() < 1e-6, "{mirrored:?} {there:?}");
        }
    }
}
