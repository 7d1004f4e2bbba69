//! The engine against values that MuJoCo 3.17.0 computed once (`cargo golden` writes the file).

use super::common::{accelerations, engine, largest_distance, relative_error, standing};
use paid_lanes::{Isa, IsaVisitor, Real};
use paid_mujoco::reference::TorqueState;
use paid_physics::{LaneState, SceneConfig, Simulator};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    mujoco: String,
    robot: String,
    states: Vec<State>,
    standing: Standing,
}

#[derive(Deserialize)]
struct State {
    #[serde(flatten)]
    pose: Pose,
    torque: Vec<f64>,
    acceleration: Vec<f64>,
    bias: Vec<f64>,
    #[serde(default)]
    mass_lower: Vec<Vec<f64>>,
}

#[derive(Deserialize)]
struct Pose {
    base_pos: [f64; 3],
    base_quat: [f64; 4],
    base_lin_vel: [f64; 3],
    base_ang_vel: [f64; 3],
    joint_pos: Vec<f64>,
    joint_vel: Vec<f64>,
}

#[derive(Deserialize)]
struct Standing {
    start: Pose,
    floor_friction: f64,
    samples: Vec<Sample>,
}

#[derive(Deserialize)]
struct Sample {
    time: f64,
    body_pos: Vec<[f64; 3]>,
}

impl Pose {
    fn lane_state(&self) -> LaneState {
        LaneState {
            base_pos: self.base_pos,
            base_quat: self.base_quat,
            base_lin_vel: self.base_lin_vel,
            base_ang_vel: self.base_ang_vel,
            joint_pos: self.joint_pos.clone(),
            joint_vel: self.joint_vel.clone(),
            ball_pos: [5.0, 0.0, 1.0],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        }
    }
}

fn golden() -> Golden {
    serde_json::from_str(include_str!("../golden/mujoco.json")).unwrap()
}

fn torque_states(golden: &Golden) -> Vec<TorqueState> {
    golden
        .states
        .iter()
        .map(|s| TorqueState { state: s.pose.lane_state(), torque: s.torque.clone() })
        .collect()
}

fn largest_error<V: Real>() -> f64 {
    let golden = golden();
    assert_eq!(golden.states.len(), 32);
    let found = accelerations::<V>(&torque_states(&golden));
    let errors = found.iter().zip(&golden.states).map(|(a, s)| relative_error(a, &s.acceleration));
    errors.fold(0.0, f64::max)
}

#[test]
fn the_golden_file_is_of_this_robot_and_mujoco() {
    let golden = golden();
    assert_eq!((golden.mujoco.as_str(), golden.robot.as_str()), ("3.17.0", "g1"));
}

#[test]
fn accelerations_agree_in_double_precision() {
    let error = largest_error::<f64>();
    assert!(error < 1e-9, "{error:.1e}");
}

#[test]
fn accelerations_agree_in_single_precision_on_every_instruction_set() {
    struct Check;
    impl IsaVisitor for Check {
        type Output = f64;
        fn visit<V: Real<Scalar = f32>>(self) -> f64 {
            largest_error::<V>()
        }
    }
    for isa in [Isa::Avx512, Isa::Avx2, Isa::Portable].into_iter().filter(|isa| isa.available()) {
        let error = isa.dispatch(Check);
        assert!(error < 1e-4, "{isa}: {error:.1e}");
    }
}

#[test]
fn bias_forces_and_mass_matrix_agree() {
    let golden = golden();
    let mut engine = engine::<f64>(&SceneConfig::default(), 1);
    let mut matrices = 0;
    for state in &golden.states {
        engine.reset_lane(0, 0, &state.pose.lane_state());
        engine.refresh(0);
        let error = relative_error(&engine.bias(0, 0), &state.bias);
        assert!(error < 1e-9, "bias: {error:.1e}");
        if !state.mass_lower.is_empty() {
            matrices += 1;
            let mass = engine.mass_matrix(0, 0);
            let lower: Vec<f64> = mass.iter().enumerate().flat_map(|(r, row)| row[..=r].to_vec()).collect();
            let upper: Vec<f64> =
                (0..mass.len()).flat_map(|c| (0..=c).map(|r| mass[r][c]).collect::<Vec<_>>()).collect();
            for half in [lower, upper] {
                let error = relative_error(&half, &state.mass_lower.concat());
                assert!(error < 1e-9, "mass matrix: {error:.1e}");
            }
        }
    }
    assert_eq!(matrices, 4);
}

/// Five millimeters: contact models and control (explicit in MuJoCo, implicit here) differ.
#[test]
fn standing_stays_within_five_millimeters() {
    let golden = golden().standing;
    let mut scene = SceneConfig { ball: false, ..SceneConfig::default() };
    scene.ground.static_friction = golden.floor_friction;
    scene.ground.dynamic_friction = golden.floor_friction;
    let control_dt = scene.physics_dt_s * scene.substeps as f64;
    let last = golden.samples.last().unwrap().time;
    assert!(last > 0.499, "{last}");
    let found = standing(&scene, &golden.start.lane_state(), (last / control_dt).round() as usize);
    for sample in &golden.samples {
        let step = (sample.time / control_dt).round() as usize;
        let distance = largest_distance(&found[step - 1], &sample.body_pos);
        assert!(distance < 0.005, "after {} s: {:.2} mm", sample.time, 1e3 * distance);
    }
}
