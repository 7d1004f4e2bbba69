//! The engine against MuJoCo itself, on states that are in no file.

use super::common::{accelerations, engine, largest_distance, relative_error, standing};
use paid_lanes::F32Array;
use paid_mujoco::reference::{TorqueState, dynamics, random_state};
use paid_mujoco::{FloorOptions, FootShapes, Library, MujocoSim, SceneOptions};
use paid_physics::{LaneState, SceneConfig, Simulator};
use paid_robot::{RobotModel, RobotSpec};

fn mujoco(options: &SceneOptions) -> MujocoSim {
    let model = RobotModel::g1();
    let control = RobotSpec::g1().resolve(&model).unwrap();
    MujocoSim::new(&model, &control, options, 1).unwrap()
}

fn without_ball() -> SceneOptions {
    let floor = FloorOptions { friction: [1.0, 0.005, 0.0001], ..FloorOptions::default() };
    SceneOptions { ball: None, goal: None, floor, ..SceneOptions::default() }
}

#[test]
fn accelerations_bias_and_mass_agree_at_fresh_random_states() {
    let Some(_) =
        paid_testing::mujoco("accelerations_bias_and_mass_agree_at_fresh_random_states", Library::get())
    else {
        return;
    };
    let mut sim = mujoco(&without_ball());
    let model = RobotModel::g1();
    let states: Vec<TorqueState> = (0..32).map(|i| random_state(&model, 7, i)).collect();
    let double = accelerations::<f64>(&states);
    let single = accelerations::<F32Array<8>>(&states);
    let mut engine = engine::<f64>(&SceneConfig::default(), 1);
    for (i, at) in states.iter().enumerate() {
        let expected = dynamics(&mut sim, 0, at);
        let error = relative_error(&double[i], &expected.acceleration);
        assert!(error < 1e-9, "state {i}, double precision: {error:.1e}");
        let error = relative_error(&single[i], &expected.acceleration);
        assert!(error < 1e-4, "state {i}, single precision: {error:.1e}");
        engine.reset_lane(0, 0, &at.state);
        engine.refresh(0);
        let error = relative_error(&engine.bias(0, 0), &expected.bias);
        assert!(error < 1e-9, "state {i}, bias: {error:.1e}");
        let error = relative_error(&engine.mass_matrix(0, 0).concat(), &expected.mass.concat());
        assert!(error < 1e-9, "state {i}, mass matrix: {error:.1e}");
    }
}

#[test]
fn body_poses_and_velocities_agree() {
    let Some(_) = paid_testing::mujoco("body_poses_and_velocities_agree", Library::get()) else { return };
    let mut sim = mujoco(&without_ball());
    let mut engine = engine::<f64>(&SceneConfig { ball: false, ..SceneConfig::default() }, 1);
    let model = RobotModel::g1();
    for index in 0..8 {
        let state = random_state(&model, 8, index).state;
        sim.reset_lane(0, 0, &state);
        sim.refresh(0);
        engine.reset_lane(0, 0, &state);
        engine.refresh(0);
        for (b, (mine, other)) in engine.state(0).bodies.iter().zip(&sim.state(0).bodies).enumerate() {
            let name = &model.bodies[b].name;
            let pairs = [
                (mine.pos, other.pos),
                (mine.lin_vel, other.lin_vel),
                (mine.com_vel, other.com_vel),
                (mine.ang_vel, other.ang_vel),
                (mine.rot.col(0), other.rot.col(0)),
                (mine.rot.col(2), other.rot.col(2)),
            ];
            for (a, b) in pairs {
                assert!((a - b).norm() < 1e-10, "{name}: {a:?} and {b:?}");
            }
        }
    }
}

#[test]
fn standing_stays_within_five_millimeters_on_either_shape_of_the_feet() {
    let test = "standing_stays_within_five_millimeters_on_either_shape_of_the_feet";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    for feet in [FootShapes::Referee, FootShapes::Sole] {
        let mut sim = mujoco(&SceneOptions { feet, ..without_ball() });
        let target = sim.save_lane(0, 0).joint_pos;
        let start = LaneState {
            base_pos: [0.0, 0.0, RobotSpec::g1().nominal_height_m],
            warm_start: Vec::new(),
            ..sim.save_lane(0, 0)
        };
        sim.reset_lane(0, 0, &start);
        let scene = SceneConfig { ball: false, ..SceneConfig::default() };
        for (step, found) in standing(&scene, &start, 25).iter().enumerate() {
            sim.step(0, &target);
            let expected: Vec<[f64; 3]> = sim.state(0).bodies.iter().map(|b| b.pos.0).collect();
            let distance = largest_distance(found, &expected);
            assert!(distance < 0.005, "{feet:?}, control step {step}: {:.2} mm", 1e3 * distance);
        }
    }
}
