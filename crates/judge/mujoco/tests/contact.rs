//! How a converted contact behaves in MuJoCo.

use paid_mujoco::contact::{damping_ratio, least_time_constant};
use paid_mujoco::{BallOptions, Library, MujocoSim, SceneOptions};
use paid_physics::Simulator;
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

/// A ball thrown at a wall, the floor of a scene without gravity, at `speed` `[m/s]`: restitution, time of contact `[s]`, indentation `[m]`.
fn thrown(ball: BallOptions, dt_s: f64, speed: f64) -> [f64; 3] {
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
    let radius = ball.params.radius_m;
    let mut start = sim.save_lane(0, 0);
    start.base_pos[2] = 2.0;
    (start.ball_pos, start.ball_vel) = ([3.0, 0.0, radius + 0.05], [0.0, 0.0, -speed]);
    sim.reset_lane(0, 0, &start);
    let (mut contact_s, mut deepest) = (0.0, 0.0_f64);
    for _ in 0..(0.3 / dt_s) as usize {
        sim.step(0, &control.default_pos);
        let depth = radius - sim.state(0).ball.pos.z();
        contact_s += if depth > 0.0 { dt_s } else { 0.0 };
        deepest = deepest.max(depth);
    }
    [sim.state(0).ball.vel.z() / speed, contact_s, deepest]
}

#[test]
fn the_real_ball_bounces_as_filmed_and_the_usual_one_does_not() {
    let Some(_) =
        paid_testing::mujoco("the_real_ball_bounces_as_filmed_and_the_usual_one_does_not", Library::get())
    else {
        return;
    };
    for dt_s in [0.0005, 0.002] {
        for speed in [2.0, 9.0, 14.0, 19.0] {
            let [real, usual] =
                [BallOptions::real(), BallOptions::default()].map(|ball| thrown(ball, dt_s, speed));
            for (name, [restitution, contact_s, depth]) in [("real", real), ("usual", usual)] {
                let [ms, mm] = [contact_s, depth].map(|x| 1e3 * x);
                println!("{name} ball, {speed} m/s, {dt_s} s: {restitution:.3}, {ms:.1} ms, {mm:.0} mm");
            }
            let [restitution, contact_s, depth] = real;
            assert!((0.80..0.89).contains(&restitution) && (0.0055..0.0085).contains(&contact_s), "{speed}");
            assert!(speed < 9.0 || (0.012..0.045).contains(&depth), "{depth}");
            let [restitution, contact_s, _] = usual;
            assert!((0.10..0.16).contains(&restitution) && (0.06..0.09).contains(&contact_s), "{speed}");
        }
    }
}
