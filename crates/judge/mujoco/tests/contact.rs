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
