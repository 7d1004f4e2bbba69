//! The own robot, other robots, and people's legs.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_robot::{BodyPose, RobotModel, RobotSpec, Shape, kinematics};

use super::draw::Draw;
use crate::render::{Form, Paint, Solid, V3};
use crate::{Pose, VisionError};

/// A robot that can be posed and painted.
#[derive(Clone, Debug)]
pub struct Robot {
    model: RobotModel,
    default_pos: Vec<f64>,
    height_m: f64,
    torso: usize,
}

/// How a robot stands.
#[derive(Clone, Debug)]
pub struct Stance {
    /// Place of its base `[m]`.
    pub base: [f64; 3],
    /// Orientation of its base, w, x, y, z.
    pub quat: [f64; 4],
    /// Joint angles, model order `[rad]`.
    pub joints: Vec<f64>,
}

impl Robot {
    /// The Unitree G1.
    ///
    /// # Errors
    /// If the robot's own description has no torso.
    pub fn g1() -> Result<Self, VisionError> {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let wrong = |found: String| VisionError::value("robot g1", "a complete description", found);
        let control = spec.resolve(&model).map_err(|error| wrong(error.to_string()))?;
        let torso = model.body_index("torso_link").ok_or_else(|| wrong("no torso_link".to_owned()))?;
        Ok(Self { model, default_pos: control.default_pos, height_m: spec.nominal_height_m, torso })
    }

    /// The robot's description.
    pub fn model(&self) -> &RobotModel {
        &self.model
    }

    /// The default stance at a place, with a heading `[rad]`.
    pub fn standing(&self, place: [f64; 2], heading: f64) -> Stance {
        let quat = Quat::<f64>::from_axis_angle(Vec3([0.0, 0.0, 1.0]), heading).0;
        Stance { base: [place[0], place[1], self.height_m], quat, joints: self.default_pos.clone() }
    }

    /// Poses of all bodies.
    pub fn bodies(&self, stance: &Stance) -> Vec<BodyPose<f64>> {
        kinematics::forward(&self.model, Vec3(stance.base), Quat(stance.quat), &stance.joints)
    }

    /// Pose of the torso in the world.
    pub fn torso(&self, bodies: &[BodyPose<f64>]) -> Pose {
        let pose = &bodies[self.torso];
        Pose { rot: pose.rot(), pos: pose.pos }
    }

    /// The robot's shapes, dark joints and light shells.
    pub fn solids(&self, bodies: &[BodyPose<f64>], colors: [V3; 2]) -> Vec<Solid> {
        let mut solids = Vec::new();
        for (index, (body, pose)) in self.model.bodies.iter().zip(bodies).enumerate() {
            let rot = pose.rot();
            for geom in &body.geoms {
                // MuJoCo's feet and our soles fill the same place.
                if geom.class == "referee" {
                    continue;
                }
                let form = placed(&geom.shape, pose, &rot);
                let paint = Paint::Plain { color: colors[index % 2], gloss: 0.3 };
                solids.push(Solid { form, paint, velocity: [0.0; 3] });
            }
        }
        solids
    }

    /// A stance as in walking, or (`kick`) with one leg swung to the front.
    pub(super) fn walking(&self, draw: &mut Draw, place: [f64; 2], heading: f64, kick: bool) -> Stance {
        let mut stance = self.standing(place, heading);
        for (joint, angle) in self.model.joints.iter().zip(&mut stance.joints) {
            let deviation = if joint.name.contains("waist") { 0.06 } else { 0.12 };
            *angle = (*angle + draw.normal(deviation)).clamp(joint.range[0], joint.range[1]);
        }
        let mut set = |name: &str, add: f64| {
            if let Some(j) = self.model.joint_index(name) {
                let [low, high] = self.model.joints[j].range;
                stance.joints[j] = (stance.joints[j] + add).clamp(low, high);
            }
        };
        // A step: one leg ahead, the other behind.
        let phase = draw.normal(0.25);
        set("left_hip_pitch_joint", phase);
        set("right_hip_pitch_joint", -phase);
        set("left_knee_joint", draw.between(0.0, 0.5));
        set("right_knee_joint", draw.between(0.0, 0.5));
        if kick {
            let side = draw.one_of(&["left", "right"]);
            set(&format!("{side}_hip_pitch_joint"), draw.between(-1.3, -0.2));
            set(&format!("{side}_knee_joint"), draw.between(-0.5, 0.8));
        }
        let turn = |axis: [f64; 3], angle: f64| Quat::<f64>::from_axis_angle(Vec3(axis), angle);
        let lean = turn([0.0, 1.0, 0.0], draw.normal(0.05)).mul(turn([1.0, 0.0, 0.0], draw.normal(0.04)));
        stance.quat = Quat(stance.quat).mul(lean).normalize().0;
        stance.base[2] += draw.normal(0.025);
        stance
    }
}

/// A shape of a body in the world.
fn placed(shape: &Shape, pose: &BodyPose<f64>, rot: &Mat3<f64>) -> Form {
    let world = |p: [f64; 3]| pose.point(Vec3(p)).0.map(|v| v as f32);
    match *shape {
        Shape::Sphere { center, radius } => Form::Sphere { center: world(center), radius: radius as f32 },
        Shape::Capsule { ends, radius } => Form::Capsule { ends: ends.map(world), radius: radius as f32 },
        Shape::Box { center, half_size, quat } => {
            let own = rot.mul_mat(&Quat(quat).to_mat());
            Form::Box {
                center: world(center),
                half_size: half_size.map(|v| v as f32),
                axes: [0, 1, 2].map(|k| own.col(k).0.map(|v| v as f32)),
            }
        }
    }
}

/// Two legs in trousers and shoes.
pub(super) fn person(draw: &mut Draw, place: [f32; 2]) -> Vec<Solid> {
    let [c, s] = draw.heading();
    let trousers = draw.color([0.0, 0.7], [0.01, 0.6]);
    let skin = draw.one_of(&[[0.5, 0.3, 0.2], [0.25, 0.13, 0.08], [0.65, 0.45, 0.35]]);
    let shoe = draw.color([0.0, 0.9], [0.01, 0.9]);
    let short = draw.chance(0.4);
    let mut solids = Vec::new();
    for side in [-1.0_f32, 1.0] {
        let step = draw.between_f32(-0.25, 0.25);
        let foot = [place[0] + side * 0.1 * s + step * c, place[1] - side * 0.1 * c + step * s];
        let hip = [place[0] + side * 0.09 * s, place[1] - side * 0.09 * c, 0.9];
        let knee = [0.5 * (foot[0] + hip[0]) + 0.05 * c, 0.5 * (foot[1] + hip[1]) + 0.05 * s, 0.48];
        let ankle = [foot[0], foot[1], 0.09];
        let toe = [foot[0] + 0.17 * c, foot[1] + 0.17 * s, 0.05];
        let limbs = [
            ([ankle, knee], 0.05, if short { skin } else { trousers }),
            ([knee, hip], 0.075, trousers),
            ([[ankle[0], ankle[1], 0.05], toe], 0.045, shoe),
        ];
        solids.extend(limbs.map(|(ends, radius, color)| Solid {
            form: Form::Capsule { ends, radius },
            paint: Paint::Plain { color, gloss: 0.0 },
            velocity: [0.0; 3],
        }));
    }
    solids
}
