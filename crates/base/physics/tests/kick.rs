//! Robot and ball exchange momentum.

use crate::common::{biped, lane_at, passive, reset_all};
use paid_lanes::Vec3;
use paid_physics::{BallParams, Engine, EnvParams, Material, SceneConfig, Simulator};

/// A leg swings in free space, a resting ball waits at its toe.
struct Kick {
    engine: Engine<f64>,
    start: paid_physics::LaneState,
    foot: usize,
    joint: usize,
    restitution: f64,
}

fn kick(restitution: f64) -> Kick {
    let (model, spec) = passive(biped());
    let scene = SceneConfig { gravity: 0.0, substeps: 1, self_collision: false, ..SceneConfig::default() };
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    let smooth = |restitution| Material { static_friction: 0.0, dynamic_friction: 0.0, restitution };
    let ball = BallParams {
        material: smooth(restitution),
        linear_damping: 0.0,
        angular_damping: 0.0,
        ..BallParams::default()
    };
    engine.set_params(0, 0, &EnvParams { robot: smooth(restitution), ball, ..EnvParams::default() });
    let foot = model.body_index("right_foot").unwrap();
    let joint = model.joint_index("right_hip_pitch_joint").unwrap();
    let mut start = lane_at(model.joints.len(), 10.0);
    start.joint_vel[joint] = -6.0;
    reset_all(&mut engine, &start);
    // The foot's capsule ends 0.12 m ahead and 0.04 m below the ankle; radius 0.03 m.
    let toe = engine.state(0).bodies[foot].pos + Vec3([0.12, 0.0, -0.04]);
    start.ball_pos = [toe.0[0] + 0.03 + ball.radius_m, toe.0[1], toe.0[2]];
    reset_all(&mut engine, &start);
    Kick { engine, start, foot, joint, restitution }
}

/// Velocity of the point of the foot at world point `p` per velocity of each degree of freedom, along x.
fn jacobian_x(
    engine: &mut Engine<f64>,
    start: &paid_physics::LaneState,
    foot: usize,
    p: Vec3<f64>,
) -> Vec<f64> {
    let n = start.joint_pos.len();
    (0..n + 6)
        .map(|dof| {
            let mut unit = start.clone();
            unit.joint_vel.fill(0.0);
            match dof {
                0..3 => unit.base_lin_vel[dof] = 1.0,
                3..6 => unit.base_ang_vel[dof - 3] = 1.0,
                _ => unit.joint_vel[dof - 6] = 1.0,
            }
            reset_all(engine, &unit);
            let body = &engine.state(0).bodies[foot];
            (body.lin_vel + body.ang_vel.cross(p - body.pos)).0[0]
        })
        .collect()
}

fn momentum(engine: &Engine<f64>) -> Vec3<f64> {
    let mut sum = Vec3::zero();
    for (state, body) in engine.state(0).bodies.iter().zip(&engine.model().bodies) {
        sum += state.com_vel.scale(body.mass);
    }
    sum
}

#[test]
fn exchanges_momentum_like_two_bodies_with_the_foots_effective_mass() {
    // The last two are those of the paper's ball on grass and on hard ground.
    for restitution in [0.0, 0.6, 0.71, 0.75] {
        let mut k = kick(restitution);
        let ball_mass = BallParams::default().mass_kg;
        let contact = Vec3(k.start.ball_pos) - Vec3([BallParams::default().radius_m, 0.0, 0.0]);
        let jacobian = jacobian_x(&mut k.engine, &k.start, k.foot, contact);
        reset_all(&mut k.engine, &k.start);
        let n = jacobian.len();
        let mut inverse_mass = 0.0;
        for c in 0..n {
            let column = k.engine.inverse_mass_column(0, c);
            inverse_mass += jacobian[c] * column.iter().zip(&jacobian).map(|(m, j)| m * j).sum::<f64>();
        }
        let effective = 1.0 / inverse_mass;
        let approach = jacobian[6 + k.joint] * k.start.joint_vel[k.joint];
        assert!(approach > 3.0, "the toe moves at {approach} m/s");
        assert!(effective > 0.1 && effective < 20.0, "effective mass {effective} kg");
        let want = (1.0 + k.restitution) * approach * effective / (effective + ball_mass);

        let before = momentum(&k.engine);
        let targets = vec![0.0; k.start.joint_pos.len()];
        k.engine.step(0, &targets);
        let ball = &k.engine.state(0).ball;
        assert!(
            (ball.vel.0[0] - want).abs() < 0.02 * want,
            "e {restitution}: ball leaves at {} m/s, expected {want}",
            ball.vel.0[0]
        );
        assert_eq!(ball.touched_by, k.foot as f64);
        let force = ball_mass * ball.vel.norm() / 0.005;
        let on_ball = ball.vel.scale(ball_mass / 0.005);
        assert!((ball.robot_force - on_ball).norm() < 1e-6 * force, "{:?}, {on_ball:?}", ball.robot_force);
        let on_foot = k.engine.state(0).contact_force[k.foot];
        assert!((on_foot + on_ball).norm() < 1e-6 * force, "the ball pushes back: {on_foot:?}, {on_ball:?}");

        let gained = ball.vel.scale(ball_mass);
        let lost = before - momentum(&k.engine);
        assert!((gained - lost).norm() < 0.05 * gained.norm(), "ball {gained:?}, robot {lost:?}");
    }
}

#[test]
fn every_shaped_body_meets_the_ball() {
    let (model, spec) = biped();
    for body in 0..model.bodies.len() {
        if !model.bodies[body].geoms.iter().any(|g| g.class == "collision") {
            continue;
        }
        let scene = SceneConfig { gravity: 0.0, substeps: 1, ..SceneConfig::default() };
        let mut engine = Engine::<f64>::new(&model, spec.clone(), &scene, 1).unwrap();
        let mut start = lane_at(model.joints.len(), 10.0);
        reset_all(&mut engine, &start);
        let paid_robot::Shape::Capsule { ends, radius } =
            model.bodies[body].geoms.iter().find(|g| g.class == "collision").unwrap().shape
        else {
            panic!("the test biped has capsules");
        };
        let state = &engine.state(0).bodies[body];
        let middle = (Vec3(ends[0]) + Vec3(ends[1])).scale(0.5);
        let target = state.pos + state.rot.mul_vec(middle);
        // From the front, 1 cm before the surface, toward the body.
        start.ball_pos = (target + Vec3([radius + 0.12, 0.0, 0.0])).0;
        start.ball_vel = [-4.0, 0.0, 0.0];
        reset_all(&mut engine, &start);
        let targets = vec![0.0; model.joints.len()];
        let mut touched = false;
        for _ in 0..20 {
            engine.step(0, &targets);
            touched |= engine.state(0).ball.touched_by == body as f64;
        }
        let vel = engine.state(0).ball.vel.0[0];
        assert!(touched, "{} was not touched", model.bodies[body].name);
        assert!(vel > -2.0, "{}: ball continues at {vel} m/s", model.bodies[body].name);
        assert!(
            engine.state(0).bodies[0].lin_vel.0[0] < 0.0,
            "{} takes no momentum",
            model.bodies[body].name
        );
    }
}
