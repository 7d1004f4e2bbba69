//! Sticking below and sliding above the static limit, on an inclined plane made of heights.

use paid_lanes::Vec3;
use paid_robot::{Body, Geom, Joint, RobotModel, Shape};

use super::ground::Ground;
use super::{Engine, EngineSpec};
use crate::{BallParams, Combine, EnvParams, LaneState, Material, SceneConfig, Simulator};

const CELL: f64 = 0.5;
const SIZE: usize = 200;
/// The middle of the slope, away from where the periodic grid jumps `[m]`.
const MIDDLE: f64 = 50.0;

fn body(name: &str, parent: Option<usize>, pos: [f64; 3], mass: f64, geoms: Vec<Geom>) -> Body {
    let i = mass * 0.02;
    Body {
        name: name.to_owned(),
        parent,
        pos,
        quat: [1.0, 0.0, 0.0, 0.0],
        mass,
        com: [0.0; 3],
        inertia: [i, i, i, 0.0, 0.0, 0.0],
        geoms,
    }
}

/// A low block on two feet with one stiff hip each.
fn block() -> (RobotModel, EngineSpec) {
    let mut bodies = vec![body("block", None, [0.0, 0.0, 0.11], 10.0, Vec::new())];
    let mut joints = Vec::new();
    for (i, sign) in [1.0, -1.0].into_iter().enumerate() {
        let soles = [[0.1, 0.03], [0.1, -0.03], [-0.1, 0.03], [-0.1, -0.03]].map(|[x, y]| Geom {
            name: format!("sole {x} {y}"),
            class: "sole".to_owned(),
            shape: Shape::Sphere { center: [x, y, 0.0], radius: 0.01 },
        });
        bodies.push(body(&format!("foot{i}"), Some(0), [0.0, 0.1 * sign, -0.1], 1.0, soles.to_vec()));
        joints.push(Joint {
            name: format!("hip{i}"),
            body: i + 1,
            axis: [0.0, 1.0, 0.0],
            range: [-1.0, 1.0],
            armature: 0.01,
            friction_loss: 0.0,
            damping: 0.0,
            effort_limit: 1000.0,
        });
    }
    let model = RobotModel { name: "block".to_owned(), bodies, joints, contact_exclusions: Vec::new() };
    (model, EngineSpec { feet: vec![1, 2], stiffness: vec![2000.0; 2], damping: vec![50.0; 2] })
}

/// The block and the ball at rest on a slope that rises along x by `tan` per meter, for `seconds`.
fn slide(tan: f64, static_friction: f64, dynamic_friction: f64, seconds: f64) -> Engine<f64> {
    let (model, spec) = block();
    let material = Material { static_friction, dynamic_friction, restitution: 0.0 };
    let scene = SceneConfig {
        ground: Material { static_friction: 2.0, dynamic_friction: 2.0, restitution: 0.0 },
        ground_friction_combine: Combine::Min,
        substeps: 1,
        ..SceneConfig::default()
    };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let row: Vec<f64> = (0..SIZE).map(|i| (i as f64 * CELL - MIDDLE) * tan).collect();
    engine.ground = Ground::from_heights(&row.repeat(SIZE), SIZE, CELL);
    let ball = BallParams { material, linear_damping: 0.0, angular_damping: 0.0, ..BallParams::default() };
    let angle = tan.atan();
    let normal = Vec3([-angle.sin(), 0.0, angle.cos()]);
    let at = |y: f64, height: f64| (normal.scale(height) + Vec3([MIDDLE, y, 0.0])).0;
    let state = LaneState {
        base_pos: at(0.0, 0.11),
        base_quat: [(0.5 * angle).cos(), 0.0, -(0.5 * angle).sin(), 0.0],
        base_lin_vel: [0.0; 3],
        base_ang_vel: [0.0; 3],
        joint_pos: vec![0.0; 2],
        joint_vel: vec![0.0; 2],
        ball_pos: at(5.0, ball.radius_m),
        ball_vel: [0.0; 3],
        ball_ang_vel: [0.0; 3],
        warm_start: Vec::new(),
    };
    engine.reset_lane(0, 0, &state);
    engine.refresh(0);
    // The block settles while nothing slides, before its friction becomes that of the test.
    let grip = Material { static_friction: 2.0, dynamic_friction: 2.0, restitution: 0.0 };
    engine.set_params(0, 0, &EnvParams { robot: grip, ball, ..EnvParams::default() });
    for _ in 0..100 {
        engine.step(0, &[0.0; 2]);
    }
    let settled = LaneState {
        ball_pos: state.ball_pos,
        ball_vel: [0.0; 3],
        ball_ang_vel: [0.0; 3],
        ..engine.save_lane(0, 0)
    };
    engine.reset_lane(0, 0, &settled);
    engine.set_params(0, 0, &EnvParams { robot: material, ball, ..EnvParams::default() });
    for _ in 0..(seconds / 0.005_f64).round() as usize {
        engine.step(0, &[0.0; 2]);
    }
    engine
}

/// Speed down the slope.
fn downhill(vel: Vec3<f64>, tan: f64) -> f64 {
    let angle = tan.atan();
    -vel.dot(Vec3([angle.cos(), 0.0, angle.sin()]))
}

#[test]
fn feet_stick_below_the_static_limit() {
    // Above the dynamic coefficient: only static friction holds. It has some to spare, because the feet of a settled block
    // also strain against each other.
    let engine = slide(0.3, 0.7, 0.1, 0.5);
    let s = engine.state(0);
    assert!(downhill(s.bodies[0].lin_vel, 0.3).abs() < 0.01, "{:?}", s.bodies[0].lin_vel);
    assert!((s.bodies[0].pos.0[0] - MIDDLE).abs() < 0.04, "{:?}", s.bodies[0].pos);
}

#[test]
fn feet_slide_above_the_static_limit_with_the_dynamic_coefficient() {
    let (tan, mu) = (0.3_f64, 0.1);
    let engine = slide(tan, 0.25, mu, 0.5);
    let want = 0.5 * 9.81 * (tan.atan().sin() - mu * tan.atan().cos());
    let speed = downhill(engine.state(0).bodies[0].lin_vel, tan);
    assert!((speed - want).abs() < 0.05 * want, "{speed} m/s, expected {want}");
}

#[test]
fn a_ball_rolls_below_the_static_limit_and_slips_above_it() {
    let (tan, k) = (0.5_f64, BallParams::default().inertia_factor);
    let angle = tan.atan();
    let radius = BallParams::default().radius_m;
    // Rolling takes the share k / (1 + k) of the slope in friction: 0.2.
    let rolling = slide(tan, 0.22, 0.1, 0.4);
    let b = &rolling.state(0).ball;
    let want = 0.4 * 9.81 * angle.sin() / (1.0 + k);
    let speed = downhill(b.vel, tan);
    assert!((speed - want).abs() < 0.02 * want, "rolls at {speed} m/s, expected {want}");
    assert!((speed + b.ang_vel.0[1] * radius).abs() < 0.01 * speed, "slips: {:?}", b.ang_vel);

    let sliding = slide(tan, 0.18, 0.1, 0.4);
    let b = &sliding.state(0).ball;
    let want = 0.4 * 9.81 * (angle.sin() - 0.1 * angle.cos());
    let speed = downhill(b.vel, tan);
    assert!((speed - want).abs() < 0.02 * want, "slides at {speed} m/s, expected {want}");
}

#[test]
fn height_and_normal_interpolate_between_grid_points() {
    let (model, spec) = block();
    let mut engine = Engine::<f64>::new(&model, spec, &SceneConfig::default(), 1).unwrap();
    // Heights 0 1 / 2 4 on a cell of 0.5 m, periodic.
    engine.ground = Ground::from_heights(&[0.0, 1.0, 2.0, 4.0], 2, 0.5);
    assert_eq!(engine.ground_height(0, 0, [0.0, 0.0]), 0.0);
    assert_eq!(engine.ground_height(0, 0, [0.5, 0.0]), 1.0);
    assert_eq!(engine.ground_height(0, 0, [0.25, 0.25]), 1.75);
    assert_eq!(engine.ground_height(0, 0, [-0.5, 0.5]), 4.0);
    assert_eq!(engine.ground_height(0, 0, [0.75, 0.0]), 0.5);
    engine.set_params(0, 0, &EnvParams { terrain_offset: [0.5, 0.5], ..EnvParams::default() });
    assert_eq!(engine.ground_height(0, 0, [0.0, 0.0]), 4.0);
}
