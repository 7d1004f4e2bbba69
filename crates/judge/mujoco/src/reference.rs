//! Reference quantities for comparisons with other engines: random states, and what MuJoCo computes for them.
//!
//! Vectors of generalized quantities are in the layout of the built-in engine: base origin (world axes, 3), base rotation
//! (world axes, 3), joints in model order. MuJoCo's own layout differs in the base's rotation, which is in base axes: with the
//! base's rotation matrix R its accelerations and forces are multiplied by R (the derivative of R times the angular
//! velocity in base axes vanishes), rows and columns of the mass matrix likewise.

use paid_lanes::Quat;
use paid_lanes::rng::Rng;
use paid_physics::LaneState;
use paid_robot::RobotModel;

use crate::sim::{FREE_NV, MujocoSim};

/// A state with joint torques.
#[derive(Clone, Debug, PartialEq)]
pub struct TorqueState {
    /// Poses and velocities.
    pub state: LaneState,
    /// Joint torques `[N m]`, model order.
    pub torque: Vec<f64>,
}

/// What MuJoCo computes without contacts, joint limits and friction loss, passive damping being zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Dynamics {
    /// Accelerations under the torques and gravity [m/s^2, rad/s^2].
    pub acceleration: Vec<f64>,
    /// Forces that keep all accelerations at zero [N, N m].
    pub bias: Vec<f64>,
    /// Mass matrix, armature included.
    pub mass: Vec<Vec<f64>>,
}

/// The state number `index` of the stream `seed`: any base orientation, base velocities to 1 m/s and 3 rad/s, joints
/// over 90% of their range at up to 5 rad/s, torques to half of the effort limits, the base 2 m up.
pub fn random_state(model: &RobotModel, seed: u64, index: u32) -> TorqueState {
    let mut rng = Rng::new(seed, index, 0);
    let mut vector = |size: f64| -> [f64; 3] { std::array::from_fn(|_| rng.uniform(-size, size)) };
    let (base_lin_vel, base_ang_vel) = (vector(1.0), vector(3.0));
    let quat: [f64; 4] = std::array::from_fn(|_| rng.normal());
    let base_quat = Quat::<f64>(quat).normalize().0;
    let mut joint_pos = Vec::new();
    let mut joint_vel = Vec::new();
    let mut torque = Vec::new();
    for joint in &model.joints {
        let [lo, hi] = joint.range;
        joint_pos.push(0.5 * (lo + hi) + 0.9 * rng.uniform(-0.5, 0.5) * (hi - lo));
        joint_vel.push(rng.uniform(-5.0, 5.0));
        torque.push(joint.effort_limit * rng.uniform(-0.5, 0.5));
    }
    let state = LaneState {
        base_pos: [0.1, -0.2, 2.0],
        base_quat,
        base_lin_vel,
        base_ang_vel,
        joint_pos,
        joint_vel,
        ball_pos: [5.0, 0.0, 1.0],
        ball_vel: [0.0; 3],
        ball_ang_vel: [0.0; 3],
        warm_start: Vec::new(),
    };
    TorqueState { state, torque }
}

/// The robot's dynamics in a state, computed by environment `group` of `sim`, whose state is replaced.
pub fn dynamics(sim: &mut MujocoSim, group: usize, at: &TorqueState) -> Dynamics {
    use paid_physics::Simulator;
    sim.reset_lane(group, 0, &at.state);
    let world = sim.world_mut(group);
    world.ctrl_mut().copy_from_slice(&at.torque);
    world.forward();
    let n = FREE_NV + at.torque.len();
    let rot = Quat::<f64>(at.state.base_quat).to_mat();
    // Coordinates 3..6 from base to world axes; the others stay.
    let turn = |v: &[f64]| -> Vec<f64> {
        let mut out = v[..n].to_vec();
        for r in 0..3 {
            out[3 + r] = (0..3).map(|c| rot.0[r][c] * v[3 + c]).sum();
        }
        out
    };
    let flat = world.mass_matrix();
    let rows: Vec<Vec<f64>> = flat.chunks(world.nv()).take(n).map(turn).collect();
    let transposed =
        |m: &[Vec<f64>]| -> Vec<Vec<f64>> { (0..n).map(|c| m.iter().map(|row| row[c]).collect()).collect() };
    let columns: Vec<Vec<f64>> = transposed(&rows).iter().map(|c| turn(c)).collect();
    Dynamics {
        acceleration: turn(world.qacc_smooth()),
        bias: turn(world.qfrc_bias()),
        mass: transposed(&columns),
    }
}
