//! The ball on flat ground, against closed forms.

use crate::common::{biped, lane_at, reset_all};
use paid_lanes::{F32Array, Real, Vec3};
use paid_physics::{BallParams, Combine, Engine, EnvParams, Material, SceneConfig, Simulator};

const G: f64 = 9.81;

/// A scene in which the ball's own coefficients hold against the ground.
fn scene() -> SceneConfig {
    SceneConfig {
        ground: Material { static_friction: 0.0, dynamic_friction: 0.0, restitution: 0.0 },
        ground_friction_combine: Combine::Max,
        ground_restitution_combine: Combine::Max,
        substeps: 1,
        ..SceneConfig::default()
    }
}

fn ball(static_friction: f64, dynamic_friction: f64, restitution: f64) -> BallParams {
    BallParams {
        material: Material { static_friction, dynamic_friction, restitution },
        linear_damping: 0.0,
        angular_damping: 0.0,
        ..BallParams::default()
    }
}

/// An engine whose robot is far away and at rest.
fn with_ball<V: Real>(scene: &SceneConfig, ball: &BallParams, pos: [f64; 3], vel: [f64; 3]) -> Engine<V> {
    let (model, spec) = biped();
    let mut engine = Engine::new(&model, spec, scene, 1).unwrap();
    let mut start = lane_at(model.joints.len(), 50.0);
    start.ball_pos = pos;
    start.ball_vel = vel;
    let params = EnvParams { ball: *ball, ..EnvParams::default() };
    for lane in 0..V::LANES {
        engine.set_params(0, lane, &params);
    }
    reset_all(&mut engine, &start);
    engine
}

fn step<V: Real>(engine: &mut Engine<V>) {
    let targets = vec![V::zero(); engine.model().joints.len()];
    engine.step(0, &targets);
}

fn rebound<V: Real>(e: f64, height: f64) -> f64 {
    let radius = BallParams::default().radius_m;
    let mut engine = with_ball::<V>(&scene(), &ball(0.5, 0.5, e), [0.0, 0.0, radius + height], [0.0; 3]);
    let mut bounced = false;
    let mut highest: f64 = 0.0;
    for _ in 0..600 {
        step(&mut engine);
        let b = &engine.state(0).ball;
        if b.vel.0[2].lane(0) > 0.0 {
            bounced = true;
        }
        if bounced {
            highest = highest.max(b.pos.0[2].lane(0) - radius);
            if b.vel.0[2].lane(0) < 0.0 {
                break;
            }
        }
    }
    highest
}

#[test]
fn rebounds_to_the_square_of_the_restitution() {
    for e in [0.5, 0.75] {
        for height in [0.4, 0.531, 0.77, 1.0, 1.37] {
            for got in [rebound::<f64>(e, height), rebound::<F32Array<8>>(e, height)] {
                let want = e * e * height;
                assert!((got - want).abs() < 0.03 * want, "e {e}, drop {height}: {got}, expected {want}");
            }
        }
    }
}

#[test]
fn does_not_bounce_below_the_threshold_speed() {
    // 1 mm of fall gives 0.14 m/s, below the threshold of 0.2 m/s.
    let highest = rebound::<f64>(0.75, 0.001);
    assert!(highest < 1e-4, "{highest}");
}

#[test]
fn slides_with_the_dynamic_coefficient() {
    for mu in [0.07, 0.3] {
        let radius = BallParams::default().radius_m;
        let mut engine = with_ball::<f64>(&scene(), &ball(0.8, mu, 0.0), [0.0, 0.0, radius], [4.0, 0.0, 0.0]);
        let steps = 20;
        for _ in 0..steps {
            step(&mut engine);
        }
        let speed = engine.state(0).ball.vel.0[0];
        let deceleration = (4.0 - speed) / (steps as f64 * 0.005);
        assert!((deceleration - mu * G).abs() < 0.02 * mu * G, "mu {mu}: {deceleration}");
    }
}

#[test]
fn a_sliding_ball_ends_rolling() {
    for k in [0.4, 2.0 / 3.0] {
        let params = BallParams { inertia_factor: k, ..ball(0.5, 0.4, 0.0) };
        let radius = params.radius_m;
        let mut engine = with_ball::<f64>(&scene(), &params, [0.0, 0.0, radius], [3.0, 0.0, 0.0]);
        for _ in 0..300 {
            step(&mut engine);
        }
        let b = &engine.state(0).ball;
        let want = 3.0 / (1.0 + k);
        assert!((b.vel.0[0] - want).abs() < 0.01 * want, "k {k}: {}", b.vel.0[0]);
        assert!((b.ang_vel.0[1] * radius - b.vel.0[0]).abs() < 0.01 * want, "does not roll");
    }
}

#[test]
fn damping_multiplies_the_velocity_each_step() {
    let (c, a) = (0.6, 4.28);
    let params = BallParams { linear_damping: c, angular_damping: a, ..ball(0.5, 0.5, 0.0) };
    let scene = SceneConfig { gravity: 0.0, ..scene() };
    let (model, spec) = biped();
    let mut engine = Engine::<f64>::new(&model, spec, &scene, 1).unwrap();
    engine.set_params(0, 0, &EnvParams { ball: params, ..EnvParams::default() });
    let mut start = lane_at(model.joints.len(), 50.0);
    start.ball_pos = [0.0, 0.0, 3.0];
    start.ball_vel = [2.0, -1.0, 0.5];
    start.ball_ang_vel = [10.0, 20.0, -5.0];
    reset_all(&mut engine, &start);
    let n = 40;
    for _ in 0..n {
        step(&mut engine);
    }
    let b = &engine.state(0).ball;
    for k in 0..3 {
        let linear = start.ball_vel[k] * (1.0 - c * 0.005_f64).powi(n);
        let angular = start.ball_ang_vel[k] * (1.0 - a * 0.005_f64).powi(n);
        assert!((b.vel.0[k] - linear).abs() < 1e-9, "{} of {linear}", b.vel.0[k]);
        assert!((b.ang_vel.0[k] - angular).abs() < 1e-9, "{} of {angular}", b.ang_vel.0[k]);
    }
}

#[test]
fn the_ground_carries_a_resting_ball() {
    let params = ball(0.5, 0.5, 0.75);
    let mut engine = with_ball::<f64>(&scene(), &params, [0.0, 0.0, params.radius_m], [0.0; 3]);
    for _ in 0..50 {
        step(&mut engine);
    }
    let b = &engine.state(0).ball;
    assert!((b.pos.0[2] - params.radius_m).abs() < 1e-4);
    let weight = params.mass_kg * G;
    assert!((b.ground_force - Vec3([0.0, 0.0, weight])).norm() < 0.01 * weight, "{:?} N", b.ground_force);
    assert_eq!(b.robot_force.norm(), 0.0);
    assert_eq!(b.touched_by, -1.0);
}

#[test]
fn a_marker_ball_stays_where_it_is_put() {
    let scene = SceneConfig { ball: false, ..scene() };
    let mut engine = with_ball::<f64>(&scene, &ball(0.5, 0.5, 0.5), [0.3, 0.2, 1.0], [1.0, 0.0, 0.0]);
    step(&mut engine);
    assert_eq!(engine.state(0).ball.pos.0, [0.3, 0.2, 1.0]);
}

#[test]
fn a_ball_alone_moves_as_in_a_full_step() {
    let params = ball(0.8, 0.07, 0.75);
    let (pos, vel) = ([0.0, 0.0, 0.9], [2.0, 0.5, 0.0]);
    let mut full = with_ball::<f64>(&scene(), &params, pos, vel);
    let mut alone = with_ball::<f64>(&scene(), &params, pos, vel);
    for _ in 0..400 {
        step(&mut full);
        alone.step_balls(0, 1);
        let (a, b) = (&alone.state(0).ball, &full.state(0).ball);
        assert_eq!((a.pos.0, a.vel.0, a.ang_vel.0), (b.pos.0, b.vel.0, b.ang_vel.0));
        assert_eq!(a.ground_force.0, b.ground_force.0);
    }
    alone.reset_lane(0, 0, &full.save_lane(0, 0));
    alone.step_balls(0, 3);
    (0..3).for_each(|_| step(&mut full));
    assert_eq!(
        alone.state(0).ball.pos.0,
        full.state(0).ball.pos.0,
        "several steps at once are steps one by one"
    );
}

/// The paper's ball on its two surfaces (table of optimized ball parameters) and the restitution against the task's ground, 0.8, multiplied.
fn identified() -> [(&'static str, BallParams, f64); 2] {
    [("grass", [0.98, 0.15, 0.71], 4.95), ("hard", [0.77, 0.07, 0.75], 4.28)].map(
        |(name, [still, sliding, restitution], angular_damping)| {
            let damped =
                BallParams { linear_damping: 0.01, angular_damping, ..ball(still, sliding, restitution) };
            (name, damped, 0.8 * restitution)
        },
    )
}

/// The ground of the soccer task.
fn task_ground() -> SceneConfig {
    SceneConfig {
        ground: Material { static_friction: 1.0, dynamic_friction: 1.0, restitution: 0.8 },
        ground_friction_combine: Combine::Multiply,
        ground_restitution_combine: Combine::Multiply,
        ..scene()
    }
}

#[test]
fn the_identified_balls_rest_roll_and_bounce_as_their_numbers_say() {
    for (name, params, restitution) in identified() {
        let radius = params.radius_m;
        let start = |height, speed| {
            with_ball::<F32Array<8>>(&task_ground(), &params, [0.3, -0.2, radius + height], [speed, 0.0, 0.0])
        };
        let mut engine = start(0.0, 0.0);
        for _ in 0..400 {
            step(&mut engine);
        }
        let b = &engine.state(0).ball;
        let moved = [b.pos.0[0].lane(0) - 0.3, b.pos.0[1].lane(0) + 0.2, b.pos.0[2].lane(0) - radius];
        assert!(moved.iter().all(|x| x.abs() < 1e-4), "{name}: a resting ball moved by {moved:?} m");

        // 0.8 m/s without spin; once it rolls both dampings slow it: (c + k a) / (1 + k), k = 2/3.
        let mut engine = start(0.0, 0.8);
        for _ in 0..200 {
            step(&mut engine);
        }
        let rolling = engine.state(0).ball.vel.0[0].lane(0);
        for _ in 0..200 {
            step(&mut engine);
        }
        let later = engine.state(0).ball.vel.0[0].lane(0);
        let rate = (0.01 + 2.0 / 3.0 * params.angular_damping) / (5.0 / 3.0);
        let got = (rolling / later).ln();
        assert!((got - rate).abs() < 0.02 * rate, "{name}: slows at {got}/s, expected {rate}");

        let mut engine = start(0.5, 0.0);
        let (mut before, mut after) = (0.0, 0.0);
        for _ in 0..200 {
            step(&mut engine);
            after = engine.state(0).ball.vel.0[2].lane(0);
            if after > 0.0 {
                break;
            }
            before = -after;
        }
        // One step of fall more than the last one that was seen.
        let ratio = after / (before + 0.5 * 9.81 * 0.005);
        assert!((ratio - restitution).abs() < 0.02, "{name}: returns {ratio}, expected {restitution}");
    }
}
