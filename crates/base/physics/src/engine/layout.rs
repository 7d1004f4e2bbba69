//! The robot in the form that the engine's inner loops need: links in chains, constants in the lane's element type.

use paid_lanes::{Mat3, Quat, Scalar, Vec3};
use paid_robot::{Body, RobotModel, Shape};

use super::error::PhysicsError;
use super::plate::Plate;
use super::shapes::{Capsule, PairGroup, capsules, pair_groups};
use super::solver::SOLVER;
use super::spec::EngineSpec;
use crate::SceneConfig;

/// Inertial constants of a body in its (internal) frame.
#[derive(Clone, Debug)]
pub(crate) struct Inertial<S> {
    pub mass: S,
    pub com: [S; 3],
    pub inertia: [S; 6],
}

/// A body and the joint that moves it.
#[derive(Clone, Debug)]
pub(crate) struct Link<S> {
    /// Joint axis of the internal frame: 0 x, 1 y, 2 z.
    pub axis: usize,
    /// Rotation at angle zero differs from the identity.
    pub turned: bool,
    pub pos: [S; 3],
    pub rot: [[S; 3]; 3],
    pub inertial: Inertial<S>,
    pub armature: S,
    pub friction_loss: S,
    pub damping: S,
    pub stiffness: S,
    pub gain_damping: S,
    pub range: [S; 2],
    pub effort: S,
    /// Position range in [`ModelLayout::capsules`].
    pub capsules: [usize; 2],
    /// Takes part in soft ground contact.
    pub soft_ground: bool,
    /// Internal frame to body frame, where they differ.
    pub report: Option<[[S; 3]; 3]>,
}

/// Offsets of a sole's point from the mean of the points, along and across the foot, and the way up; in the foot's internal frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SoleFrame<S> {
    pub ahead: [S; 3],
    pub left: [S; 3],
    pub up: [S; 3],
}

/// Consecutive links without a branch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Chain {
    pub first: usize,
    pub end: usize,
    /// The chain whose last link carries this one; `None` for the base.
    pub parent: Option<usize>,
    /// Number of joints between the base and the first link's.
    pub depth: usize,
}

/// A step of the walk over the tree that finishes a limb before the next one, so that its numbers stay near.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Visit {
    /// Base to tip through a chain.
    Outward(usize),
    /// Tip to base through a chain whose children are done.
    Inward(usize),
}

/// Depth-first walk over `chains`.
fn walk(chains: &[Chain], parent: Option<usize>, visits: &mut Vec<Visit>) {
    for c in (0..chains.len()).filter(|&c| chains[c].parent == parent) {
        visits.push(Visit::Outward(c));
        walk(chains, Some(c), visits);
        visits.push(Visit::Inward(c));
    }
}

/// The model prepared for stepping.
#[derive(Clone, Debug)]
pub(crate) struct ModelLayout<S> {
    pub base: Inertial<S>,
    pub base_capsules: [usize; 2],
    /// Link `j` is body `j + 1`.
    pub links: Vec<Link<S>>,
    /// Depth-first: a parent before its children.
    pub chains: Vec<Chain>,
    /// The walk over the chains.
    pub visits: Vec<Visit>,
    /// Joints from the base to the end of each chain.
    pub paths: Vec<Vec<usize>>,
    /// The chains of the two legs.
    pub legs: [usize; 2],
    /// Sole sphere centers and radii, per point, left and right.
    pub soles: Vec<[([S; 3], S); 2]>,
    /// How the points of the soles move with their shape.
    pub sole_frames: Vec<[SoleFrame<S>; 2]>,
    pub capsules: Vec<Capsule<S>>,
    /// Flat shapes of the feet, left and right.
    pub plates: [Option<Plate<S>>; 2],
    pub pairs: Vec<PairGroup>,
    /// No shape reaches farther from the base's origin in any pose, with the ball's horizon to spare `[m]`.
    pub reach: f64,
}

/// An orthonormal matrix whose columns express an internal frame in which `axis` is z; `None` if `axis` is a frame axis.
fn frame_for_axis(axis: [f64; 3]) -> (usize, Option<Mat3<f64>>) {
    for k in 0..3 {
        if axis[k] == 1.0 {
            return (k, None);
        }
    }
    let norm = (axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]).sqrt();
    let z = Vec3(axis).scale(1.0 / norm);
    let helper = if z.0[0].abs() < 0.7 { Vec3::c([1.0, 0.0, 0.0]) } else { Vec3::c([0.0, 1.0, 0.0]) };
    let x = helper.scale_add(1.0, z.scale(-helper.dot(z)));
    let x = x.scale(1.0 / x.norm());
    let y = z.cross(x);
    let m = Mat3([[x.0[0], y.0[0], z.0[0]], [x.0[1], y.0[1], z.0[1]], [x.0[2], y.0[2], z.0[2]]]);
    (2, Some(m))
}

pub(crate) fn scalars<S: Scalar, const N: usize>(x: [f64; N]) -> [S; N] {
    x.map(S::from_f64)
}

fn inertial<S: Scalar>(body: &Body, frame: &Mat3<f64>) -> Inertial<S> {
    let [xx, yy, zz, xy, xz, yz] = body.inertia;
    let i = Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]);
    let i = frame.tr_mul_mat(&i.mul_mat(frame)).0;
    Inertial {
        mass: S::from_f64(body.mass),
        com: scalars(frame.tr_mul_vec(Vec3(body.com)).0),
        inertia: scalars([i[0][0], i[1][1], i[2][2], i[0][1], i[0][2], i[1][2]]),
    }
}

fn check_order(model: &RobotModel) -> Result<(), PhysicsError> {
    let mut open = Vec::new();
    for (i, body) in model.bodies.iter().enumerate() {
        let bad = || PhysicsError::Order(body.name.clone());
        match body.parent {
            None if i == 0 => {}
            Some(p) if i > 0 && p < i => {
                while open.last().is_some_and(|&o| o != p) {
                    open.pop();
                }
                if open.is_empty() || model.joints.get(i - 1).is_none_or(|j| j.body != i) {
                    return Err(bad());
                }
            }
            _ => return Err(bad()),
        }
        open.push(i);
    }
    if model.bodies.is_empty() || model.joints.len() + 1 != model.bodies.len() {
        return Err(PhysicsError::Order(model.name.clone()));
    }
    Ok(())
}

/// Splits the tree into unbranched chains and lists the joints from the base to the end of each.
fn split_chains(model: &RobotModel) -> (Vec<Chain>, Vec<Vec<usize>>) {
    let mut children = vec![0; model.bodies.len()];
    for body in &model.bodies {
        if let Some(p) = body.parent {
            children[p] += 1;
        }
    }
    let mut chains: Vec<Chain> = Vec::new();
    let mut chain_of = vec![None; model.bodies.len()];
    for (i, body) in model.bodies.iter().enumerate().skip(1) {
        let parent = body.parent.unwrap_or(0);
        let joint = i - 1;
        if parent != 0 && children[parent] == 1 {
            let c = chain_of[parent];
            chain_of[i] = c;
            if let Some(c) = c {
                let chain: &mut Chain = &mut chains[c];
                chain.end = joint + 1;
            }
        } else {
            chain_of[i] = Some(chains.len());
            let depth =
                chain_of[parent].map_or(0, |p: usize| chains[p].depth + chains[p].end - chains[p].first);
            chains.push(Chain { first: joint, end: joint + 1, parent: chain_of[parent], depth });
        }
    }
    let mut paths: Vec<Vec<usize>> = Vec::new();
    for chain in &chains {
        let mut path = chain.parent.map_or_else(Vec::new, |p| paths[p].clone());
        path.extend(chain.first..chain.end);
        paths.push(path);
    }
    (chains, paths)
}

/// An upper bound of the distance from the base's origin to any `collision` shape, and the ball's horizon beyond.
fn reach(model: &RobotModel) -> f64 {
    let norm = |v: [f64; 3]| Vec3(v).norm();
    let mut origin = vec![0.0; model.bodies.len()];
    let mut out: f64 = 0.0;
    for (b, body) in model.bodies.iter().enumerate() {
        if let Some(p) = body.parent {
            origin[b] = origin[p] + norm(body.pos);
        }
        for geom in &body.geoms {
            let extent = match geom.shape {
                Shape::Sphere { center, radius } => norm(center) + radius,
                Shape::Capsule { ends, radius } => norm(ends[0]).max(norm(ends[1])) + radius,
                Shape::Box { center, half_size, .. } => norm(center) + norm(half_size),
            };
            out = out.max(origin[b] + extent);
        }
    }
    out + SOLVER.ball_horizon_m
}

fn sole_points<S: Scalar>(body: &Body, frame: &Mat3<f64>) -> Result<Vec<([S; 3], S)>, PhysicsError> {
    let mut points = Vec::new();
    for geom in body.geoms.iter().filter(|g| g.class == "sole") {
        let Shape::Sphere { center, radius } = geom.shape else {
            return Err(PhysicsError::Geom {
                body: body.name.clone(),
                geom: geom.name.clone(),
                problem: "a `sole` must be a sphere",
            });
        };
        points.push((scalars(frame.tr_mul_vec(Vec3(center)).0), S::from_f64(radius)));
    }
    Ok(points)
}

/// The frames of `points` in a foot whose internal frame is `frame` in the body's.
fn sole_frames<S: Scalar>(points: &[([S; 3], S)], frame: &Mat3<f64>) -> Vec<SoleFrame<S>> {
    let centers: Vec<Vec3<f64>> = points.iter().map(|(c, _)| frame.mul_vec(Vec3(c.map(S::to_f64)))).collect();
    let sum = centers.iter().fold(Vec3([0.0; 3]), |sum, c| sum + *c);
    let mean = sum.scale(1.0 / centers.len().max(1) as f64);
    let inside = |v: [f64; 3]| scalars(frame.tr_mul_vec(Vec3(v)).0);
    let of = |c: &Vec3<f64>| {
        let [x, y, _] = (*c - mean).0;
        SoleFrame { ahead: inside([x, 0.0, 0.0]), left: inside([0.0, y, 0.0]), up: inside([0.0, 0.0, 1.0]) }
    };
    centers.iter().map(of).collect()
}

impl<S: Scalar> ModelLayout<S> {
    /// Checks and prepares the model.
    pub fn new(model: &RobotModel, spec: &EngineSpec, scene: &SceneConfig) -> Result<Self, PhysicsError> {
        check_order(model)?;
        let joints = model.joints.len();
        for (what, list) in [("stiffness", &spec.stiffness), ("damping", &spec.damping)] {
            if list.len() != joints {
                return Err(PhysicsError::Length { what, expected: joints, found: list.len() });
            }
        }
        let feet = <[usize; 2]>::try_from(&spec.feet[..]).map_err(|_| PhysicsError::Feet(spec.feet.len()))?;
        let (chains, paths) = split_chains(model);
        let mut legs = [0; 2];
        for (leg, foot) in legs.iter_mut().zip(feet) {
            let name = model.bodies.get(foot).map_or_else(|| foot.to_string(), |b| b.name.clone());
            let is_leg = |c: &Chain| c.end == foot && c.parent.is_none() && foot > 0;
            let chain = chains.iter().position(is_leg).ok_or_else(|| PhysicsError::Foot(name.clone()))?;
            if chains.iter().any(|c| c.parent == Some(chain)) {
                return Err(PhysicsError::Foot(name));
            }
            *leg = chain;
        }
        if legs[0] == legs[1] {
            return Err(PhysicsError::Foot(model.bodies[feet[1]].name.clone()));
        }
        let frames: Vec<(usize, Option<Mat3<f64>>)> =
            core::iter::once((2, None)).chain(model.joints.iter().map(|j| frame_for_axis(j.axis))).collect();
        let frame = |body: usize| frames[body].1.unwrap_or_else(Mat3::identity);
        let (capsules, ranges) = capsules(model, &frame)?;
        let identity = Mat3::<f64>::identity().0;
        let mut links = Vec::with_capacity(joints);
        for (j, joint) in model.joints.iter().enumerate() {
            let body = &model.bodies[j + 1];
            let parent = frame(body.parent.unwrap_or(0));
            let rot = parent.tr_mul_mat(&Quat(body.quat).normalize().to_mat().mul_mat(&frame(j + 1)));
            links.push(Link {
                axis: frames[j + 1].0,
                turned: rot.0 != identity,
                pos: scalars(parent.tr_mul_vec(Vec3(body.pos)).0),
                rot: rot.0.map(scalars),
                inertial: inertial(body, &frame(j + 1)),
                armature: S::from_f64(joint.armature),
                friction_loss: S::from_f64(joint.friction_loss),
                damping: S::from_f64(joint.damping),
                stiffness: S::from_f64(spec.stiffness[j]),
                gain_damping: S::from_f64(spec.damping[j]),
                range: scalars(joint.range),
                effort: S::from_f64(joint.effort_limit),
                capsules: ranges[j + 1],
                soft_ground: !feet.contains(&(j + 1)),
                report: frames[j + 1].1.map(|m| m.0.map(scalars)),
            });
        }
        let [left, right] = feet.map(|f| sole_points::<S>(&model.bodies[f], &frame(f)));
        let (left, right) = (left?, right?);
        if left.is_empty() || left.len() != right.len() {
            return Err(PhysicsError::Soles(left.len(), right.len()));
        }
        let frames_of = |points: &[([S; 3], S)], f: usize| sole_frames(points, &frame(feet[f]));
        let sole_frames =
            frames_of(&left, 0).into_iter().zip(frames_of(&right, 1)).map(|(l, r)| [l, r]).collect();
        let plates = [(&left, feet[0]), (&right, feet[1])]
            .map(|(points, f)| Plate::new(points, &capsules, ranges[f], &frame(f)));
        let reach = reach(model);
        let mut visits = Vec::new();
        walk(&chains, None, &mut visits);
        let pairs = if scene.self_collision {
            pair_groups(model, &chains, &legs, (&capsules, &ranges))
        } else {
            Vec::new()
        };
        Ok(Self {
            base: inertial(&model.bodies[0], &Mat3::identity()),
            base_capsules: ranges[0],
            links,
            chains,
            visits,
            paths,
            legs,
            sole_frames,
            soles: left.into_iter().zip(right).map(|(l, r)| [l, r]).collect(),
            capsules,
            plates,
            pairs,
            reach,
        })
    }
}
