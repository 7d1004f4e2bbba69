//! What the generator must know of a robot's body.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec, Shape, kinematics};

use super::GenerateError;

/// A humanoid with two legs of which each foot has a flat sole; indices are of the model. Pairs are left, right.
#[derive(Clone, Debug)]
pub struct Biped<'a> {
    /// The robot.
    pub model: &'a RobotModel,
    /// Foot bodies.
    pub feet: [usize; 2],
    /// Joints from the base to each foot.
    pub legs: [Vec<usize>; 2],
    /// Of each leg the joints for ankle roll, ankle pitch and hip turn (axes x, y, z; the last x and y, the only z).
    pub free: [[usize; 3]; 2],
    /// The body that a clip's displacement is measured at.
    pub anchor: usize,
    /// Toe end of the foot's collision shape, foot frame `[m]`: the part that meets the ball.
    pub toe: [[f64; 3]; 2],
    /// Radius of that shape `[m]`.
    pub toe_radius: f64,
    /// Points below each sole's contact balls, foot frame, foot level `[m]`.
    pub soles: [Vec<[f64; 3]>; 2],
    /// Default joint angles `[rad]`.
    pub default_pos: Vec<f64>,
    /// Range that the generator keeps to `[rad]`.
    pub range: Vec<[f64; 2]>,
    /// For each joint its mirror image and the sign of its angle there.
    pub mirror: Vec<(usize, f64)>,
}

impl<'a> Biped<'a> {
    /// Finds legs, soles and mirror images.
    ///
    /// # Errors
    /// What a kick needs and the robot lacks.
    pub fn new(model: &'a RobotModel, spec: &RobotSpec) -> Result<Self, GenerateError> {
        let control = spec.resolve(model).map_err(|e| GenerateError::Robot(e.to_string()))?;
        let body = |name: &String| {
            model.body_index(name).ok_or_else(|| GenerateError::Robot(format!("no body '{name}'")))
        };
        let feet = [body(&spec.feet[0])?, body(&spec.feet[1])?];
        let chain = |foot: usize| {
            let mut joints = Vec::new();
            let mut at = foot;
            while let Some(parent) = model.bodies[at].parent {
                joints.push(at - 1);
                at = parent;
            }
            joints.reverse();
            joints
        };
        let legs = feet.map(chain);
        if legs[0].len() != legs[1].len() || legs[0].len() < 6 {
            return Err(GenerateError::Robot(format!(
                "expected two legs of at least 6 joints each, found {} and {}",
                legs[0].len(),
                legs[1].len()
            )));
        }
        let free = |leg: &Vec<usize>| {
            let last = |axis: usize| {
                leg.iter().rev().copied().find(|&j| model.joints[j].axis[axis].abs() > 0.9).ok_or_else(|| {
                    GenerateError::Robot(format!("no leg joint about axis {}", ["x", "y", "z"][axis]))
                })
            };
            Ok([last(0)?, last(1)?, last(2)?])
        };
        let free = [free(&legs[0])?, free(&legs[1])?];
        let soles = feet.map(|foot| soles(model, foot));
        let [Some((left, radius)), Some((right, _))] = feet.map(|foot| toe(model, foot)) else {
            return Err(GenerateError::Robot("no capsule of class 'collision' on each foot".to_owned()));
        };
        if soles.iter().any(|s| s.len() < 3) {
            return Err(GenerateError::Robot("fewer than 3 balls of class 'sole' on a foot".to_owned()));
        }
        Ok(Self {
            model,
            feet,
            legs,
            free,
            anchor: body(&spec.anchor_body)?,
            toe: [left, right],
            toe_radius: radius,
            soles,
            default_pos: control.default_pos,
            range: model.joints.iter().map(|j| inner(j.range)).collect(),
            mirror: model.mirrored_joints().map_err(|e| GenerateError::Robot(e.to_string()))?,
        })
    }

    /// Height of the foot frame's origin when the sole is flat on the floor `[m]`.
    pub fn sole_height(&self) -> f64 {
        -self.soles[0].iter().map(|p| p[2]).fold(f64::INFINITY, f64::min)
    }

    /// Middle of the sole in the foot frame, x forward `[m]`.
    pub fn sole_center(&self) -> f64 {
        let xs = self.soles[0].iter().map(|p| p[0]);
        let (low, high) = xs.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        f64::midpoint(low, high)
    }

    /// Height of the base and half the distance of the feet in the default pose, soles on the floor `[m]`.
    pub fn stance(&self) -> (f64, f64) {
        let poses = kinematics::forward::<f64>(
            self.model,
            Vec3::zero(),
            Quat::c([1.0, 0.0, 0.0, 0.0]),
            &self.default_pos,
        );
        let half = 0.5 * (poses[self.feet[0]].pos.y() - poses[self.feet[1]].pos.y());
        (self.sole_height() - poses[self.feet[0]].pos.z(), half)
    }

    /// How far the toe point must rise so that the sole stays above the floor when the foot pitches toe-down about it `[m]`.
    pub fn dip(&self, side: usize, pitch: f64) -> f64 {
        let [tx, _, tz] = self.toe[side];
        let lowest = |angle: f64| {
            let (s, c) = angle.sin_cos();
            let heights = self.soles[side].iter().map(|p| c * (p[2] - tz) - s * (p[0] - tx));
            heights.fold(f64::INFINITY, f64::min)
        };
        lowest(0.0) - lowest(pitch)
    }

    /// A joint by the end of its name, on a side (0 left, 1 right) or in the middle.
    pub fn joint(&self, side: Option<usize>, suffix: &str) -> Option<usize> {
        let prefix = match side {
            Some(0) => "left_",
            Some(_) => "right_",
            None => "",
        };
        self.model.joint_index(&format!("{prefix}{suffix}"))
    }
}

/// The inner 95 % of a range.
fn inner([low, high]: [f64; 2]) -> [f64; 2] {
    let (middle, half) = (f64::midpoint(low, high), 0.475 * (high - low));
    [middle - half, middle + half]
}

fn soles(model: &RobotModel, foot: usize) -> Vec<[f64; 3]> {
    let balls = model.bodies[foot].geoms.iter().filter(|g| g.class == "sole");
    balls
        .filter_map(|g| match g.shape {
            Shape::Sphere { center: [x, y, z], radius } => Some([x, y, z - radius]),
            _ => None,
        })
        .collect()
}

fn toe(model: &RobotModel, foot: usize) -> Option<([f64; 3], f64)> {
    model.bodies[foot].geoms.iter().filter(|g| g.class == "collision").find_map(|g| match g.shape {
        Shape::Capsule { ends: [a, b], radius } => Some((if a[0] > b[0] { a } else { b }, radius)),
        _ => None,
    })
}
