//! How a converted contact behaves in MuJoCo.

use paid_mujoco::contact::{damping_ratio, least_time_constant};
use paid_mujoco::{BallOptions, Library, MujocoSim, SceneOptions};
use paid_physics::{Compliance, Engine, EngineSpec, EnvParams, SceneConfig, Simulator};
use paid_robot::{RobotModel, RobotSpec};

/// Share of the impact's speed that a ball returns that is dropped on the floor from 1 m.
fn rebound(restitution: f64) -> f64 {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let usual = BallOptions::default();
    let mut scene = SceneOptions { substeps: 1, ..SceneOptions::default() };
    let ratio = damping_ratio(restitution);
    let time = usual.solref[0].max(least_time_constant(ratio, scene.physics_dt_s));
    scene.ball = Some(BallOptions { solref: [time, ratio], ..usual });
    let control = spec.resolve(&model).unwrap();
    let mut sim = MujocoSim::new(&model, &control, &scene, 1).unwrap();
    let mut start = sim.save_lane(0, 0);
    start.ball_pos = [3.0, 0.0, 0.11 + 1.0];
    sim.reset_lane(0, 0, &start);
    let (mut down, mut up) = (0.0_f64, 0.0_f64);
    for _ in 0..450 {
        sim.step(0, &control.default_pos);
        let v = sim.state(0).ball.vel.z();
        down = down.max(-v);
        up = up.max(v);
    }
    up / down
}

#[test]
fn a_ball_returns_the_converted_restitution() {
    let Some(_) = paid_testing::mujoco("a_ball_returns_the_converted_restitution", Library::get()) else {
        return;
    };
    for e in [0.0, 0.3, 0.568, 0.6, 0.75, 0.9] {
        let found = rebound(e);
        // The spring lets go when its force ends, before the whole half period.
        assert!((e..e + 0.14).contains(&found), "{e}: {found}");
    }
}

/// What a wall does to a ball.
struct Bounce {
    restitution: f64,
    contact_s: f64,
    deepest_m: f64,
}

/// A ball thrown at a wall, the floor of a scene without gravity, at `speed` `[m/s]`.
fn thrown(sim: &mut impl Simulator<f64>, radius_m: f64, speed: f64) -> Bounce {
    let dt_s = sim.control_dt_s();
    let mut start = sim.save_lane(0, 0);
    start.base_pos[2] = 2.0;
    (start.ball_pos, start.ball_vel) = ([3.0, 0.0, radius_m + 0.05], [0.0, 0.0, -speed]);
    sim.reset_lane(0, 0, &start);
    let (mut contact_s, mut deepest_m) = (0.0, 0.0_f64);
    for _ in 0..(0.3 / dt_s) as usize {
        sim.step(0, &start.joint_pos);
        let depth = radius_m - sim.state(0).ball.pos.z();
        contact_s += if depth > 0.0 { dt_s } else { 0.0 };
        deepest_m = deepest_m.max(depth);
    }
    Bounce { restitution: sim.state(0).ball.vel.z() / speed, contact_s, deepest_m }
}

fn thrown_in_mujoco(ball: BallOptions, dt_s: f64, speed: f64) -> Bounce {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let scene = SceneOptions {
        physics_dt_s: dt_s,
        substeps: 1,
        gravity: 0.0,
        ball: Some(ball),
        ..SceneOptions::default()
    };
    let control = spec.resolve(&model).unwrap();
    let mut sim = MujocoSim::new(&model, &control, &scene, 1).unwrap();
    thrown(&mut sim, ball.params.radius_m, speed)
}

fn thrown_in_ours(contact: Compliance, dt_s: f64, speed: f64) -> Bounce {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let scene = SceneConfig { physics_dt_s: dt_s, substeps: 1, gravity: 0.0, ..SceneConfig::default() };
    let engine_spec = EngineSpec::for_robot(&model, &spec).unwrap();
    let mut engine = Engine::<f64>::new(&model, engine_spec, &scene, 1).unwrap();
    let mut params = EnvParams::default();
    params.kind.compliance.ball_ground = contact;
    params.ball.linear_damping = 0.0;
    engine.set_params(0, 0, &params);
    thrown(&mut engine, params.ball.radius_m, speed)
}

#[test]
fn the_real_ball_bounces_as_filmed_and_the_usual_one_does_not() {
    let Some(_) =
        paid_testing::mujoco("the_real_ball_bounces_as_filmed_and_the_usual_one_does_not", Library::get())
    else {
        return;
    };
    let print = |name: &str, dt_s: f64, speed: f64, bounce: &Bounce| {
        let Bounce { restitution, contact_s, deepest_m } = bounce;
        let [ms, mm] = [contact_s, deepest_m].map(|x| 1e3 * x);
        println!(
            "{name:26} {:.1} ms steps, {speed:4.1} m/s: {restitution:.3}, {ms:.1} ms, {mm:.0} mm",
            1e3 * dt_s
        );
    };
    for speed in [2.0, 9.0, 14.0, 19.0] {
        for dt_s in [0.0005, 0.002] {
            let real = thrown_in_mujoco(BallOptions::real(), dt_s, speed);
            print("real ball, MuJoCo", dt_s, speed, &real);
            assert!(
                (0.80..0.89).contains(&real.restitution) && (0.0055..0.0085).contains(&real.contact_s),
                "{speed}"
            );
            assert!(speed < 9.0 || (0.012..0.045).contains(&real.deepest_m), "{}", real.deepest_m);
            let usual = thrown_in_mujoco(BallOptions::default(), dt_s, speed);
            print("usual ball, MuJoCo", dt_s, speed, &usual);
            assert!(
                (0.10..0.16).contains(&usual.restitution) && (0.06..0.09).contains(&usual.contact_s),
                "{speed}"
            );
        }
        // Training's steps are as long as the contact; what counts is what the ball does afterwards.
        for dt_s in [0.0005, 0.0025, 0.005] {
            let real = thrown_in_ours(Compliance::lasting(0.0065, 0.845), dt_s, speed);
            print("real ball, built-in engine", dt_s, speed, &real);
            assert!((real.restitution - 0.845).abs() < 0.045, "{speed} {dt_s}");
        }
    }
}
