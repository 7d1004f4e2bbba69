//! Free flight: what nothing touches keeps its momentum and energy.

use crate::common::{biped, lane_at, passive, reset_all};
use paid_lanes::Vec3;
use paid_physics::{Engine, SceneConfig, Simulator};
use paid_robot::RobotModel;

/// Mass, momentum, angular momentum about the center of mass, kinetic and potential energy of the robot's bodies.
struct Totals {
    momentum: Vec3<f64>,
    spin: Vec3<f64>,
    energy: f64,
}

fn totals(model: &RobotModel, engine: &Engine<f64>, gravity: f64) -> Totals {
    let s = engine.state(0);
    let mass = model.mass();
    let mut momentum = Vec3::zero();
    let mut center = Vec3::zero();
    let placed: Vec<Vec3<f64>> =
        s.bodies.iter().zip(&model.bodies).map(|(b, m)| b.pos + b.rot.mul_vec(Vec3(m.com))).collect();
    for ((b, m), &c) in s.bodies.iter().zip(&model.bodies).zip(&placed) {
        momentum += b.com_vel.scale(m.mass);
        center += c.scale(m.mass / mass);
    }
    let mut spin = Vec3::zero();
    let mut energy = 0.0;
    for ((b, m), &c) in s.bodies.iter().zip(&model.bodies).zip(&placed) {
        let [xx, yy, zz, xy, xz, yz] = m.inertia;
        let local = b.rot.tr_mul_vec(b.ang_vel);
        let i = paid_lanes::Mat3([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).mul_vec(local);
        spin += b.rot.mul_vec(i) + (c - center).cross(b.com_vel.scale(m.mass));
        energy += 0.5 * m.mass * b.com_vel.norm2() + 0.5 * i.dot(local) - m.mass * gravity * c.0[2];
    }
    for (joint, qd) in model.joints.iter().zip(&s.joint_vel) {
        energy += 0.5 * joint.armature * qd * qd;
    }
    Totals { momentum, spin, energy }
}

/// Tumbling 20 m above the ground with all joints moving, with no forces but inertia and gravity.
fn tumble(dt: f64, seconds: f64, gravity: f64) -> (Totals, Totals) {
    let (model, spec) = passive(biped());
    let scene = SceneConfig {
        physics_dt_s: dt,
        substeps: 1,
        gravity,
        self_collision: false,
        ball: false,
        ..SceneConfig::default()
    };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let n = model.joints.len();
    let mut start = lane_at(n, 20.0);
    start.base_lin_vel = [0.5, -0.3, 0.2];
    start.base_ang_vel = [0.6, 1.0, -0.8];
    for j in 0..n {
        start.joint_pos[j] = 0.3 * (1.3 * j as f64).sin();
        start.joint_vel[j] = 1.5 * (0.7 * j as f64).cos();
    }
    reset_all(&mut engine, &start);
    let before = totals(&model, &engine, gravity);
    let targets = vec![0.0; n];
    for _ in 0..(seconds / dt).round() as usize {
        engine.step(0, &targets);
    }
    (before, totals(&model, &engine, gravity))
}

#[test]
fn momentum_is_kept_without_gravity() {
    for dt in [0.005, 0.0005] {
        let (before, after) = tumble(dt, 0.5, 0.0);
        let scale = dt / 0.005;
        assert!((after.momentum - before.momentum).norm() < 0.5 * scale, "{dt}: {:?}", after.momentum);
        assert!(
            (after.spin - before.spin).norm() < 0.05 * scale * before.spin.norm(),
            "{dt}: {:?} from {:?}",
            after.spin,
            before.spin
        );
    }
}

#[test]
fn momentum_follows_gravity() {
    let (before, after) = tumble(0.0005, 0.5, -9.81);
    let (model, _) = biped();
    let expected = before.momentum.0[2] - model.mass() * 9.81 * 0.5;
    assert!((after.momentum.0[2] - expected).abs() < 0.1, "{} of {expected}", after.momentum.0[2]);
}

#[test]
fn energy_drifts_in_proportion_to_the_step() {
    let drift = |dt| {
        let (before, after) = tumble(dt, 0.5, 0.0);
        (after.energy - before.energy) / before.energy
    };
    let (coarse, fine) = (drift(0.002), drift(0.0002));
    assert!(coarse.abs() < 0.05, "{coarse}");
    assert!(fine.abs() < 0.005, "{fine}");
}
