//! What the comparisons with MuJoCo share.

use paid_lanes::Real;
use paid_mujoco::reference::TorqueState;
use paid_physics::{Engine, EngineSpec, LaneState, SceneConfig, Simulator};
use paid_robot::{RobotModel, RobotSpec};

/// The built-in engine with the G1, `groups` groups.
pub fn engine<V: Real>(scene: &SceneConfig, groups: usize) -> Engine<V> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    Engine::new(&model, EngineSpec::for_robot(&model, &spec).unwrap(), scene, groups).unwrap()
}

/// Accelerations of states by the engine, as many per group as it has lanes.
pub fn accelerations<V: Real>(states: &[TorqueState]) -> Vec<Vec<f64>> {
    let mut engine = engine::<V>(&SceneConfig::default(), 1);
    let mut out = Vec::new();
    for chunk in states.chunks(V::LANES) {
        let mut torques = vec![V::zero(); chunk[0].torque.len()];
        for (lane, at) in chunk.iter().enumerate() {
            engine.reset_lane(0, lane, &at.state);
            for (out, torque) in torques.iter_mut().zip(&at.torque) {
                out.set_lane(lane, *torque);
            }
        }
        engine.refresh(0);
        let found = engine.accelerations(0, &torques);
        out.extend((0..chunk.len()).map(|lane| found.iter().map(|a| a.lane(lane)).collect()));
    }
    out
}

/// The largest difference of two vectors over the largest magnitude of the second.
pub fn relative_error(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let scale = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let error = found.iter().zip(expected).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    error / scale
}

/// Largest distance between corresponding points `[m]`.
pub fn largest_distance(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let distance = |(p, q): (&[f64; 3], &[f64; 3])| (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>().sqrt();
    a.iter().zip(b).map(distance).fold(0.0, f64::max)
}

/// Body origins of the engine after each of `steps` control steps in the default pose under its controllers, from `start`.
pub fn standing(scene: &SceneConfig, start: &LaneState, steps: usize) -> Vec<Vec<[f64; 3]>> {
    // Double precision alone: every number type that steps costs minutes of compilation.
    let mut engine = engine::<f64>(scene, 1);
    engine.reset_lane(0, 0, start);
    engine.refresh(0);
    (0..steps)
        .map(|_| {
            engine.step(0, &start.joint_pos);
            engine.state(0).bodies.iter().map(|b| b.pos.0).collect()
        })
        .collect()
}
