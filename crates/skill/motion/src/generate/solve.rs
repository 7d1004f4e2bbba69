//! Whole-body inverse kinematics of one frame: damped least squares over the base and both legs.

use paid_lanes::{Quat, Vec3};
use paid_robot::{BodyPose, kinematics};

use super::Biped;
use crate::rotation_log;

/// Pose of the whole robot.
#[derive(Clone, Debug)]
pub struct Pose {
    /// Base position, world `[m]`.
    pub base_pos: [f64; 3],
    /// Base orientation, w, x, y, z.
    pub base_quat: [f64; 4],
    /// Joint angles, model order `[rad]`.
    pub joints: Vec<f64>,
}

/// What a foot shall do.
#[derive(Clone, Copy, Debug)]
pub struct FootTarget {
    /// Position of the toe point ([`Biped::toe`]), world `[m]`.
    pub toe: [f64; 3],
    /// Heading when flat `[rad]`.
    pub yaw: f64,
    /// Toe-down pitch when flat `[rad]`.
    pub pitch: f64,
    /// For roll, pitch and heading, 1: the sole is level at that heading; 0: the free joints have their angles; between: a mixture of both conditions.
    pub flat: [f64; 3],
}

/// What a frame shall be. Joints outside of the legs keep the angles of the pose that the solver starts from.
#[derive(Clone, Debug)]
pub struct Target {
    /// Center of mass x, y, world `[m]`.
    pub com: [f64; 2],
    /// Height of the base `[m]`.
    pub height: f64,
    /// Orientation of the base, w, x, y, z.
    pub base_quat: [f64; 4],
    /// Left and right foot.
    pub feet: [FootTarget; 2],
    /// For each foot that is not flat the joints and angles `[rad]` that take the place of its roll, pitch and heading.
    pub free: [[(usize, f64); 3]; 2],
}

/// Weights of the tasks' errors: feet before balance before the trunk, so that what the legs cannot reach lowers the base.
const FOOT: f64 = 100.0;
const COM: f64 = 50.0;
const BASE: f64 = 10.0;
const LIMIT: f64 = 100.0;
/// Levenberg-Marquardt damping; it slows the steps down and leaves the solution as it is.
const DAMPING: f64 = 1e-4;
/// Longest joint step of one iteration `[rad]`.
const LONGEST: f64 = 0.35;
const ITERATIONS: usize = 60;
/// Steps below this end the iteration `[rad, m]`.
const CLOSE: f64 = 1e-10;

/// A dense symmetric system of the normal equations.
struct System {
    n: usize,
    a: Vec<f64>,
    b: Vec<f64>,
}

impl System {
    fn new(n: usize) -> Self {
        Self { n, a: vec![0.0; n * n], b: vec![0.0; n] }
    }

    fn add(&mut self, row: &[f64], error: f64, weight: f64) {
        let w = weight * weight;
        for i in 0..self.n {
            if row[i] == 0.0 {
                continue;
            }
            self.b[i] += w * row[i] * error;
            for j in 0..=i {
                self.a[i * self.n + j] += w * row[i] * row[j];
            }
        }
    }

    /// Cholesky factorization and substitution, in place.
    fn solve(mut self) -> Vec<f64> {
        let n = self.n;
        for i in 0..n {
            for j in 0..=i {
                let mut sum = self.a[i * n + j];
                for k in 0..j {
                    sum -= self.a[i * n + k] * self.a[j * n + k];
                }
                self.a[i * n + j] = if i == j { sum.max(1e-12).sqrt() } else { sum / self.a[j * n + j] };
            }
        }
        for i in 0..n {
            for k in 0..i {
                self.b[i] -= self.a[i * n + k] * self.b[k];
            }
            self.b[i] /= self.a[i * n + i];
        }
        for i in (0..n).rev() {
            for k in i + 1..n {
                self.b[i] -= self.a[k * n + i] * self.b[k];
            }
            self.b[i] /= self.a[i * n + i];
        }
        self.b
    }
}

/// Moves base and legs of `pose` until the target is met as well as the weights allow; returns the length of the last step.
pub fn solve(figure: &Biped<'_>, pose: &mut Pose, target: &Target) -> f64 {
    let mut last = f64::INFINITY;
    for _ in 0..ITERATIONS {
        let step = iterate(figure, pose, target);
        last = step;
        if step < CLOSE {
            break;
        }
    }
    last
}

fn iterate(figure: &Biped<'_>, pose: &mut Pose, target: &Target) -> f64 {
    let model = figure.model;
    let poses = kinematics::forward::<f64>(model, Vec3(pose.base_pos), Quat(pose.base_quat), &pose.joints);
    let legs: Vec<usize> = figure.legs.iter().flatten().copied().collect();
    let n = 6 + legs.len();
    let mut system = System::new(n);
    let base = poses[0].pos;
    let mut row = vec![0.0; n];

    // Center of mass, and that of everything beyond each joint.
    let (mass, moments) = subtree_moments(figure, &poses);
    let com = moments[0].scale(1.0 / mass[0]);
    for k in 0..2 {
        row.fill(0.0);
        row[k] = 1.0;
        turn_part(&mut row, com - base, k);
        for (i, &j) in legs.iter().enumerate() {
            let body = model.joints[j].body;
            let axis = poses[body].quat.rotate(Vec3(model.joints[j].axis));
            let arm = moments[body] - poses[body].pos.scale(mass[body]);
            row[6 + i] = axis.cross(arm).0[k] / mass[0];
        }
        system.add(&row, target.com[k] - com.0[k], COM);
    }
    // Base.
    row.fill(0.0);
    row[2] = 1.0;
    system.add(&row, target.height - base.z(), BASE);
    let off = rotation_log(pose.base_quat, target.base_quat);
    for k in 0..3 {
        row.fill(0.0);
        row[3 + k] = 1.0;
        system.add(&row, off[k], BASE);
    }
    // Feet.
    for (side, foot) in target.feet.iter().enumerate() {
        let body = figure.feet[side];
        let point = poses[body].point(Vec3(figure.toe[side]));
        let columns = &figure.legs[side];
        let first = 6 + if side == 0 { 0 } else { figure.legs[0].len() };
        let axis = |j: usize| poses[j + 1].quat.rotate(Vec3(model.joints[j].axis));
        for k in 0..3 {
            row.fill(0.0);
            row[k] = 1.0;
            turn_part(&mut row, point - base, k);
            for (i, &j) in columns.iter().enumerate() {
                row[first + i] = axis(j).cross(point - poses[j + 1].pos).0[k];
            }
            system.add(&row, foot.toe[k] - point.0[k], FOOT);
        }
        // Three more conditions: the sole's tilt and heading (foot axes), the free joints, or a mixture of both errors.
        let level = Quat::from_roll_pitch_yaw(0.0, foot.pitch, foot.yaw);
        let rot = poses[body].quat.to_mat();
        let off = rot.tr_mul_vec(Vec3(rotation_log(poses[body].quat.0, level.0)));
        for k in 0..3 {
            row.fill(0.0);
            let (flat, free) = (foot.flat[k], 1.0 - foot.flat[k]);
            row[3..6].copy_from_slice(&rot.col(k).scale(flat).0);
            for (i, &j) in columns.iter().enumerate() {
                row[first + i] = flat * axis(j).dot(rot.col(k));
            }
            let mut error = flat * off.0[k];
            if free > 0.0 {
                let (joint, angle) = target.free[side][k];
                if let Some(i) = columns.iter().position(|&j| j == joint) {
                    row[first + i] += free;
                }
                error += free * (angle - pose.joints[joint]);
            }
            system.add(&row, error, FOOT);
        }
    }
    for (i, &j) in legs.iter().enumerate() {
        let (angle, [low, high]) = (pose.joints[j], figure.range[j]);
        let beyond = (low - angle).max(0.0) - (angle - high).max(0.0);
        if beyond != 0.0 {
            row.fill(0.0);
            row[6 + i] = 1.0;
            system.add(&row, beyond, LIMIT);
        }
    }
    for i in 0..n {
        system.a[i * n + i] += DAMPING;
    }
    apply(pose, &legs, system.solve())
}

/// Adds the base's rotation to row `k` of a point's Jacobian: the point moves by `w x arm`.
fn turn_part(row: &mut [f64], arm: Vec3<f64>, k: usize) {
    let [x, y, z] = arm.0;
    let cross = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]];
    row[3..6].copy_from_slice(&cross[k]);
}

/// Mass and first moment `[kg m, world]` of each body with everything beyond it.
fn subtree_moments(figure: &Biped<'_>, poses: &[BodyPose<f64>]) -> (Vec<f64>, Vec<Vec3<f64>>) {
    let bodies = &figure.model.bodies;
    let mut mass: Vec<f64> = bodies.iter().map(|b| b.mass).collect();
    let mut moments: Vec<Vec3<f64>> =
        bodies.iter().zip(poses).map(|(b, pose)| pose.point(Vec3(b.com)).scale(b.mass)).collect();
    for i in (1..bodies.len()).rev() {
        if let Some(parent) = bodies[i].parent {
            mass[parent] += mass[i];
            let moment = moments[i];
            moments[parent] += moment;
        }
    }
    (mass, moments)
}

fn apply(pose: &mut Pose, legs: &[usize], mut step: Vec<f64>) -> f64 {
    let longest = step.iter().fold(0.0_f64, |m, s| m.max(s.abs()));
    if longest > LONGEST {
        let shrink = LONGEST / longest;
        step.iter_mut().for_each(|s| *s *= shrink);
    }
    for k in 0..3 {
        pose.base_pos[k] += step[k];
    }
    let turn = Vec3([step[3], step[4], step[5]]);
    let angle = turn.norm();
    if angle > 0.0 {
        let by = Quat::from_axis_angle(turn.scale(1.0 / angle), angle);
        pose.base_quat = by.mul(Quat(pose.base_quat)).normalize().0;
    }
    for (i, &j) in legs.iter().enumerate() {
        pose.joints[j] += step[6 + i];
    }
    longest
}
