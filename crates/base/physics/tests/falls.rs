//! Falling, lying, and limbs against limbs.

use crate::common::{biped, lane_at, passive, reset_all};
use paid_lanes::Vec3;
use paid_physics::{Engine, EngineSpec, EnvParams, Material, SceneConfig, Simulator};
use paid_robot::{RobotModel, Shape};

/// Lowest point of any `collision` shape (except of the feet, whose soles carry them) and its body.
fn lowest(engine: &Engine<f64>, feet: &[usize]) -> (f64, String) {
    let mut out = (f64::MAX, String::new());
    for (i, (state, body)) in engine.state(0).bodies.iter().zip(&engine.model().bodies).enumerate() {
        for geom in body.geoms.iter().filter(|g| g.class == "collision" && !feet.contains(&i)) {
            let (ends, radius) = match geom.shape {
                Shape::Sphere { center, radius } => ([center; 2], radius),
                Shape::Capsule { ends, radius } => (ends, radius),
                Shape::Box { .. } => continue,
            };
            for end in ends {
                let z = (state.pos + state.rot.mul_vec(Vec3(end))).0[2] - radius;
                if z < out.0 {
                    out = (z, geom.name.clone());
                }
            }
        }
    }
    out
}

fn g1() -> (RobotModel, EngineSpec, Vec<f64>) {
    let model = RobotModel::g1();
    let spec = paid_robot::RobotSpec::g1();
    let control = spec.resolve(&model).unwrap();
    let engine = EngineSpec::for_robot(&model, &spec).unwrap();
    (model, engine, control.default_pos)
}

#[test]
fn a_lying_robot_sinks_less_than_two_centimeters() {
    let (model, spec, default) = g1();
    // Forward, backward, onto each side.
    let half = std::f64::consts::FRAC_1_SQRT_2;
    for quat in
        [[half, 0.0, half, 0.0], [half, 0.0, -half, 0.0], [half, half, 0.0, 0.0], [half, -half, 0.0, 0.0]]
    {
        let mut engine = Engine::<f64>::new(&model, spec.clone(), &SceneConfig::default(), 1).unwrap();
        let mut start = lane_at(model.joints.len(), 0.4);
        start.base_quat = quat;
        start.joint_pos = default.clone();
        reset_all(&mut engine, &start);
        for _ in 0..100 {
            engine.step(0, &default);
        }
        for step in 0..50 {
            engine.step(0, &default);
            let (z, name) = lowest(&engine, &spec.feet);
            assert!(z > -0.02, "{quat:?}: {name} at {z} m, control step {step}");
        }
        let pelvis = &engine.state(0).bodies[0];
        assert!(pelvis.pos.0[2] < 0.35, "{quat:?}: lies at {} m", pelvis.pos.0[2]);
        assert!(pelvis.lin_vel.norm() < 0.2, "{quat:?}: still moves at {:?}", pelvis.lin_vel);
    }
}

/// From the nearest point of the second capsule's axis to that of the first's, and the sum of the radii.
fn apart(engine: &Engine<f64>, a: &str, b: &str) -> (Vec3<f64>, f64) {
    let sample = |name: &str| -> (Vec<Vec3<f64>>, f64) {
        let model = engine.model();
        let i = model.body_index(name).unwrap();
        let state = &engine.state(0).bodies[i];
        let Shape::Capsule { ends, radius } = model.bodies[i].geoms[0].shape else {
            panic!("{name} has a capsule");
        };
        let [p, q] = ends.map(|e| state.pos + state.rot.mul_vec(Vec3(e)));
        ((0..=200).map(|k| (q - p).scale_add(f64::from(k) / 200.0, p)).collect(), radius)
    };
    let ((pa, ra), (pb, rb)) = (sample(a), sample(b));
    let all = pa.iter().flat_map(|p| pb.iter().map(move |q| *p - *q));
    (all.min_by(|d, e| d.norm2().total_cmp(&e.norm2())).unwrap(), ra + rb)
}

/// Gap between two capsules given by their bodies' names.
fn gap(engine: &Engine<f64>, a: &str, b: &str) -> f64 {
    let (d, radii) = apart(engine, a, b);
    d.norm() - radii
}

#[test]
fn legs_do_not_pass_through_each_other() {
    let (model, spec) = biped();
    let scene = SceneConfig { gravity: 0.0, ball: false, ..SceneConfig::default() };
    for self_collision in [true, false] {
        let scene = SceneConfig { self_collision, ..scene.clone() };
        let mut engine = Engine::<f64>::new(&model, spec.clone(), &scene, 1).unwrap();
        let mut start = lane_at(model.joints.len(), 5.0);
        reset_all(&mut engine, &start);
        start.joint_pos[model.joint_index("left_hip_roll_joint").unwrap()] = 0.1;
        reset_all(&mut engine, &start);
        // Both legs are driven 0.5 rad across the middle.
        let mut targets = vec![0.0; model.joints.len()];
        targets[model.joint_index("left_hip_roll_joint").unwrap()] = -0.5;
        targets[model.joint_index("right_hip_roll_joint").unwrap()] = 0.5;
        let mut deepest = f64::MAX;
        for _ in 0..100 {
            engine.step(0, &targets);
            for (a, b) in
                [("left_shin", "right_shin"), ("left_foot", "right_foot"), ("left_thigh", "right_thigh")]
            {
                deepest = deepest.min(gap(&engine, a, b));
            }
        }
        if self_collision {
            assert!(deepest > -0.01, "legs overlap by {} m", -deepest);
            let force = engine.state(0).contact_force[model.body_index("left_foot").unwrap()].norm()
                + engine.state(0).contact_force[model.body_index("left_shin").unwrap()].norm();
            assert!(force > 10.0, "the legs press with {force} N");
        } else {
            assert!(deepest < -0.03, "without self-collision the legs must cross, got {deepest}");
        }
    }
}

#[test]
fn colliding_legs_keep_the_robots_momentum() {
    let (model, spec) = passive(biped());
    let scene = SceneConfig { gravity: 0.0, ball: false, physics_dt_s: 0.001, ..SceneConfig::default() };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let mut start = lane_at(model.joints.len(), 5.0);
    start.joint_vel[model.joint_index("left_hip_roll_joint").unwrap()] = -2.0;
    start.joint_vel[model.joint_index("right_hip_roll_joint").unwrap()] = 2.0;
    reset_all(&mut engine, &start);
    let momentum = |e: &Engine<f64>| {
        let mut sum = Vec3::zero();
        for (state, body) in e.state(0).bodies.iter().zip(&e.model().bodies) {
            sum += state.com_vel.scale(body.mass);
        }
        sum
    };
    let before = momentum(&engine);
    let mut touched = false;
    let targets = vec![0.0; model.joints.len()];
    for _ in 0..30 {
        engine.step(0, &targets);
        touched |= engine.state(0).contact_force.iter().any(|f| f.norm() > 0.0);
    }
    assert!(touched);
    assert!((momentum(&engine) - before).norm() < 0.05, "{:?} from {before:?}", momentum(&engine));
}

#[test]
fn hands_stay_out_of_the_thighs() {
    let (model, spec, default) = g1();
    let scene = SceneConfig { ball: false, gravity: 0.0, ..SceneConfig::default() };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let mut start = lane_at(model.joints.len(), 5.0);
    start.joint_pos = default.clone();
    reset_all(&mut engine, &start);
    // Straight arms pulled inwards against the thighs.
    let mut targets = default;
    for (name, angle) in
        [("left_shoulder_roll_joint", -0.5), ("left_elbow_joint", 1.4), ("left_shoulder_pitch_joint", 0.0)]
    {
        targets[model.joint_index(name).unwrap()] = angle;
    }
    let mut deepest = f64::MAX;
    for _ in 0..100 {
        engine.step(0, &targets);
        deepest = deepest.min(gap(&engine, "left_wrist_yaw_link", "left_hip_roll_link"));
    }
    assert!(deepest < 0.01, "the hand must reach the thigh, nearest {deepest} m");
    assert!(deepest > -0.015, "the hand enters the thigh by {} m", -deepest);
}

/// The first blow between the legs of a floating robot that swing at and past each other, at `friction` between the two: force on the left
/// leg along the contact's normal and across `[N]`.
fn blow(friction: f64) -> [f64; 2] {
    let (model, spec) = passive(biped());
    let scene =
        SceneConfig { gravity: 0.0, ball: false, physics_dt_s: 0.001, substeps: 1, ..SceneConfig::default() };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let robot = Material { static_friction: friction, dynamic_friction: friction, restitution: 0.0 };
    engine.set_params(0, 0, &EnvParams { robot, ..EnvParams::default() });
    let mut start = lane_at(model.joints.len(), 5.0);
    for (joint, speed) in
        [("left_hip_roll", -2.0), ("right_hip_roll", 2.0), ("left_hip_pitch", 2.0), ("right_hip_pitch", -2.0)]
    {
        start.joint_vel[model.joint_index(&format!("{joint}_joint")).unwrap()] = speed;
    }
    reset_all(&mut engine, &start);
    let targets = vec![0.0; model.joints.len()];
    for _ in 0..100 {
        let nearest =
            ["shin", "foot"].map(|part| apart(&engine, &format!("left_{part}"), &format!("right_{part}")));
        engine.step(0, &targets);
        let left = model
            .bodies
            .iter()
            .zip(&engine.state(0).contact_force)
            .filter(|(b, _)| b.name.starts_with("left"));
        let force = left.fold(Vec3::zero(), |sum, (_, f)| sum + *f);
        if force.norm() > 0.0 {
            let (d, _) = nearest
                .into_iter()
                .min_by(|(a, r), (b, q)| (a.norm() - r).total_cmp(&(b.norm() - q)))
                .unwrap();
            let along = force.dot(d.scale(1.0 / d.norm()));
            return [along, (force.norm2() - along * along).max(0.0).sqrt()];
        }
    }
    panic!("the legs do not meet");
}

#[test]
fn limbs_that_slide_on_each_other_rub_with_the_robots_friction() {
    for friction in [0.0, 0.3, 0.8] {
        let [along, across] = blow(friction);
        assert!(along > 100.0, "friction {friction}: a blow of {along} N");
        assert!((across / along - friction).abs() < 0.01, "friction {friction}: {across} N across {along} N");
    }
}
