//! What the optimization knows of the robot: where everything is in a frame, and how it moves with the frame's variables.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec, Shape, SpecError, kinematics};

use super::rows::Row;
use crate::check::collision_pairs;
use crate::generate::Pose;

/// A contact shape as a segment with a radius, body frame `[m]`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rod {
    pub ends: [Vec3<f64>; 2],
    pub radius: f64,
}

/// The robot's fixed numbers.
pub(super) struct Figure<'a> {
    pub model: &'a RobotModel,
    /// Variables of a frame: base position, base rotation (world axes), joints.
    pub n: usize,
    /// For each body the joints between it and the base.
    pub paths: Vec<Vec<usize>>,
    /// Left, right.
    pub feet: [usize; 2],
    /// Centers and radii of the balls below each foot, foot frame `[m]`.
    pub soles: [Vec<(Vec3<f64>, f64)>; 2],
    pub speed_limit: Vec<f64>,
    pub default_pos: Vec<f64>,
    pub mass: f64,
    pub inertia: Vec<Mat3<f64>>,
    pub pairs: Vec<(usize, usize)>,
    pub rods: Vec<Vec<Rod>>,
    /// Ends of the arms: the last body of every chain that is no foot.
    pub hands: Vec<usize>,
}

/// A frame's bodies in the world.
#[derive(Clone)]
pub(super) struct Frame {
    pub pos: Vec<Vec3<f64>>,
    pub quat: Vec<Quat<f64>>,
    pub com: Vec<Vec3<f64>>,
    /// Axis of each joint.
    pub axis: Vec<Vec3<f64>>,
}

impl<'a> Figure<'a> {
    pub fn new(model: &'a RobotModel, spec: &RobotSpec) -> Result<Self, SpecError> {
        let indices = spec.indices(model)?;
        let control = spec.resolve(model)?;
        let mut paths: Vec<Vec<usize>> = vec![Vec::new()];
        for joint in &model.joints {
            let mut path = paths[model.bodies[joint.body].parent.unwrap_or(0)].clone();
            path.push(paths.len() - 1);
            paths.push(path);
        }
        let has_child = |i: usize| model.bodies.iter().any(|b| b.parent == Some(i));
        let feet = indices.feet;
        let hands = (1..model.bodies.len()).filter(|&i| !has_child(i) && !feet.contains(&i)).collect();
        let rods = |i: usize| {
            let solid = model.bodies[i].geoms.iter().filter(|g| g.class == "collision");
            solid
                .map(|g| {
                    let (a, b, radius) = crate::check::rod(&g.shape);
                    Rod { ends: [Vec3(a), Vec3(b)], radius }
                })
                .collect()
        };
        Ok(Self {
            n: 6 + model.joints.len(),
            paths,
            feet,
            soles: feet.map(|foot| sole_balls(model, foot)),
            speed_limit: control.velocity_limit,
            default_pos: control.default_pos,
            mass: model.mass(),
            inertia: model
                .bodies
                .iter()
                .map(|b| {
                    let [xx, yy, zz, xy, xz, yz] = b.inertia;
                    Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
                })
                .collect(),
            pairs: collision_pairs(model),
            rods: (0..model.bodies.len()).map(rods).collect(),
            hands,
            model,
        })
    }

    /// All bodies of a pose.
    pub fn frame(&self, pose: &Pose) -> Frame {
        let poses =
            kinematics::forward::<f64>(self.model, Vec3(pose.base_pos), Quat(pose.base_quat), &pose.joints);
        let com = self.model.bodies.iter().zip(&poses).map(|(b, p)| p.point(Vec3(b.com))).collect();
        let axis = self.model.joints.iter().map(|j| poses[j.body].quat.rotate(Vec3(j.axis))).collect();
        Frame {
            pos: poses.iter().map(|p| p.pos).collect(),
            quat: poses.iter().map(|p| p.quat).collect(),
            com,
            axis,
        }
    }

    /// Adds `dir . d(point)` to a row, for a point of `body` that is at `point` in the world; `first` is the frame's first variable.
    pub fn add_point(
        &self,
        f: &Frame,
        body: usize,
        point: Vec3<f64>,
        dir: Vec3<f64>,
        first: usize,
        row: &mut Row,
    ) {
        let turn = (point - f.pos[0]).cross(dir);
        for k in 0..3 {
            row.add(first + k, dir.0[k]);
            row.add(first + 3 + k, turn.0[k]);
        }
        for &j in &self.paths[body] {
            let arm = point - f.pos[self.model.joints[j].body];
            row.add(first + 6 + j, f.axis[j].dot(arm.cross(dir)));
        }
    }

    /// Adds `dir . d(rotation vector)` of `body` to a row.
    pub fn add_turn(&self, f: &Frame, body: usize, dir: Vec3<f64>, first: usize, row: &mut Row) {
        for k in 0..3 {
            row.add(first + 3 + k, dir.0[k]);
        }
        for &j in &self.paths[body] {
            row.add(first + 6 + j, f.axis[j].dot(dir));
        }
    }

    /// Lowest points of a foot's sole, world `[m]`.
    pub fn sole_points(&self, f: &Frame, side: usize) -> Vec<Vec3<f64>> {
        let foot = self.feet[side];
        self.soles[side]
            .iter()
            .map(|&(p, r)| f.pos[foot] + f.quat[foot].rotate(p) - Vec3([0.0, 0.0, r]))
            .collect()
    }

    /// Height of the foot's frame above the floor when its sole lies flat on it `[m]`.
    pub fn sole_height(&self, side: usize) -> f64 {
        self.soles[side].iter().map(|(p, r)| r - p.z()).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The balls of class `sole`, else the ends of all that is of class `collision`.
fn sole_balls(model: &RobotModel, foot: usize) -> Vec<(Vec3<f64>, f64)> {
    let balls = |class: &str| -> Vec<(Vec3<f64>, f64)> {
        let geoms = model.bodies[foot].geoms.iter().filter(|g| g.class == class);
        geoms
            .flat_map(|g| match g.shape {
                Shape::Sphere { center, radius } => vec![(Vec3(center), radius)],
                Shape::Capsule { ends, radius } => ends.map(|e| (Vec3(e), radius)).to_vec(),
                Shape::Box { center, .. } => vec![(Vec3(center), 0.0)],
            })
            .collect()
    };
    let soles = balls("sole");
    if soles.is_empty() { balls("collision") } else { soles }
}
