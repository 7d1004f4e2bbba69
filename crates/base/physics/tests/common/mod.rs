//! A small biped and helpers that the engine's tests share.

use paid_lanes::Real;
use paid_physics::{Engine, EngineSpec, LaneState, SceneConfig, Simulator};
use paid_robot::{Body, Geom, Joint, RobotModel, Shape};

/// Height of the base at which straight legs touch the ground `[m]`.
pub const STRAIGHT_HEIGHT: f64 = 0.80;

fn capsule(name: &str, ends: [[f64; 3]; 2], radius: f64) -> Geom {
    Geom { name: name.to_owned(), class: "collision".to_owned(), shape: Shape::Capsule { ends, radius } }
}

struct Builder {
    model: RobotModel,
    stiffness: Vec<f64>,
    damping: Vec<f64>,
}

impl Builder {
    #[allow(clippy::too_many_arguments)]
    fn body(
        &mut self,
        name: &str,
        parent: usize,
        pos: [f64; 3],
        axis: [f64; 3],
        mass: f64,
        length: f64,
        stiffness: f64,
        geoms: Vec<Geom>,
    ) -> usize {
        let index = self.model.bodies.len();
        let inertia = mass * (length * length / 12.0 + 0.03 * 0.03);
        self.model.bodies.push(Body {
            name: name.to_owned(),
            parent: Some(parent),
            pos,
            quat: [1.0, 0.0, 0.0, 0.0],
            mass,
            com: [0.003, 0.002, -0.5 * length],
            inertia: [inertia, 1.1 * inertia, 0.4 * inertia, 0.0, 0.02 * inertia, 0.0],
            geoms,
        });
        self.model.joints.push(Joint {
            name: format!("{name}_joint"),
            body: index,
            axis,
            range: [-2.5, 2.5],
            armature: 0.01,
            friction_loss: 0.1,
            damping: 0.0,
            effort_limit: 120.0,
        });
        self.stiffness.push(stiffness);
        self.damping.push(0.06 * stiffness);
        index
    }
}

/// A biped of 33 kg: legs of six joints, one waist joint, arms of three.
pub fn biped() -> (RobotModel, EngineSpec) {
    let base = Body {
        name: "base".to_owned(),
        parent: None,
        pos: [0.0, 0.0, STRAIGHT_HEIGHT],
        quat: [1.0, 0.0, 0.0, 0.0],
        mass: 5.0,
        com: [0.01, 0.0, 0.02],
        inertia: [0.03, 0.02, 0.025, 0.0, 0.001, 0.0],
        geoms: vec![capsule("pelvis", [[0.0, -0.05, 0.0], [0.0, 0.05, 0.0]], 0.08)],
    };
    let mut b = Builder {
        model: RobotModel {
            name: "biped".to_owned(),
            bodies: vec![base],
            joints: Vec::new(),
            contact_exclusions: Vec::new(),
        },
        stiffness: Vec::new(),
        damping: Vec::new(),
    };
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let mut feet = [0; 2];
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let hip =
            b.body(&format!("{side}_hip_pitch"), 0, [0.0, 0.1 * sign, -0.1], y, 1.2, 0.05, 400.0, vec![]);
        let roll = b.body(&format!("{side}_hip_roll"), hip, [0.0, 0.0, 0.0], x, 1.5, 0.05, 400.0, vec![]);
        let thigh = capsule("thigh", [[0.0, 0.0, -0.05], [0.0, 0.0, -0.25]], 0.06);
        let yaw = b.body(&format!("{side}_thigh"), roll, [0.0; 3], z, 2.5, 0.3, 400.0, vec![thigh]);
        let shin = capsule("shin", [[0.0, 0.0, -0.03], [0.0, 0.0, -0.28]], 0.045);
        let knee = b.body(&format!("{side}_shin"), yaw, [0.0, 0.0, -0.3], y, 2.0, 0.3, 400.0, vec![shin]);
        let ankle = b.body(&format!("{side}_ankle"), knee, [0.0, 0.0, -0.33], y, 0.1, 0.02, 300.0, vec![]);
        let mut geoms = vec![capsule("foot", [[-0.04, 0.0, -0.04], [0.12, 0.0, -0.04]], 0.03)];
        for (i, (px, py)) in [(0.12, 0.03), (0.12, -0.03), (-0.05, 0.03), (-0.05, -0.03)].iter().enumerate() {
            geoms.push(Geom {
                name: format!("sole{i}"),
                class: "sole".to_owned(),
                shape: Shape::Sphere { center: [*px, *py, -0.06], radius: 0.01 },
            });
        }
        feet[usize::from(side == "right")] =
            b.body(&format!("{side}_foot"), ankle, [0.0; 3], x, 0.7, 0.05, 300.0, geoms);
    }
    let torso = capsule("torso", [[0.0, -0.04, -0.1], [0.0, 0.04, -0.1]], 0.1);
    let head = capsule("head", [[0.0, 0.0, 0.35], [0.0, 0.0, 0.4]], 0.08);
    let waist = b.body("torso", 0, [0.0, 0.0, 0.25], z, 9.0, 0.3, 150.0, vec![torso, head]);
    // An axis that is no frame axis, for generality.
    let tilted = [0.0, 0.8, 0.6];
    for (side, sign) in [("left", 1.0), ("right", -1.0)] {
        let at = [0.0, 0.21 * sign, 0.15];
        let upper = vec![capsule("upper_arm", [[0.0, 0.0, 0.0], [0.0, 0.0, -0.2]], 0.04)];
        let shoulder = b.body(&format!("{side}_shoulder"), waist, at, tilted, 1.2, 0.2, 40.0, upper);
        let fore = vec![capsule("forearm", [[0.0, 0.0, 0.0], [0.0, 0.0, -0.2]], 0.035)];
        let elbow = b.body(&format!("{side}_forearm"), shoulder, [0.0, 0.0, -0.25], y, 0.8, 0.2, 40.0, fore);
        let hand = vec![capsule("hand", [[0.0, 0.0, -0.03], [0.0, 0.0, -0.08]], 0.04)];
        b.body(&format!("{side}_hand"), elbow, [0.0, 0.0, -0.22], [-1.0, 0.0, 0.0], 0.4, 0.1, 20.0, hand);
    }
    let spec = EngineSpec { feet: feet.to_vec(), stiffness: b.stiffness, damping: b.damping };
    (b.model, spec)
}

/// An engine of one group of the small biped.
pub fn engine<V: Real>(scene: &SceneConfig) -> Engine<V> {
    let (model, spec) = biped();
    Engine::new(&model, spec, scene, 1).expect("the test biped is valid")
}

/// At rest with all joints at zero, base at `height`, ball far away.
pub fn lane_at(joints: usize, height: f64) -> LaneState {
    LaneState {
        base_pos: [0.0, 0.0, height],
        base_quat: [1.0, 0.0, 0.0, 0.0],
        base_lin_vel: [0.0; 3],
        base_ang_vel: [0.0; 3],
        joint_pos: vec![0.0; joints],
        joint_vel: vec![0.0; joints],
        ball_pos: [5.0, 0.0, 0.11],
        ball_vel: [0.0; 3],
        ball_ang_vel: [0.0; 3],
        warm_start: Vec::new(),
    }
}

/// Puts every lane of group 0 into `state` and refreshes.
pub fn reset_all<V: Real>(engine: &mut Engine<V>, state: &LaneState) {
    for lane in 0..V::LANES {
        engine.reset_lane(0, lane, state);
    }
    engine.refresh(0);
}

/// Legs slightly bent, so that a push does not find straight knees.
pub fn stance(model: &RobotModel) -> Vec<f64> {
    let mut q = vec![0.0; model.joints.len()];
    for side in ["left", "right"] {
        for (joint, angle) in [("hip_pitch", -0.3), ("shin", 0.6), ("ankle", -0.3)] {
            let j = model.joint_index(&format!("{side}_{joint}_joint")).expect("joint of the test biped");
            q[j] = angle;
        }
    }
    q
}

/// Without controllers, friction and damping in the joints, and with joint ranges that nothing reaches.
pub fn passive((mut model, mut spec): (RobotModel, EngineSpec)) -> (RobotModel, EngineSpec) {
    for joint in &mut model.joints {
        joint.friction_loss = 0.0;
        joint.damping = 0.0;
        joint.range = [-100.0, 100.0];
    }
    spec.stiffness.fill(0.0);
    spec.damping.fill(0.0);
    (model, spec)
}
