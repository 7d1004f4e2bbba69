//! The robot on its feet.

use crate::common::{biped, engine, lane_at, reset_all, stance};
use paid_physics::{SceneConfig, Simulator};

/// Base height at which the bent stance touches the ground.
fn stance_height() -> f64 {
    0.1 + 0.3 * 0.3_f64.cos() + 0.33 * 0.3_f64.cos() + 0.07
}

#[test]
fn stands_for_two_seconds_and_sinks_less_than_two_millimeters() {
    let (model, _) = biped();
    let mut e = engine::<f64>(&SceneConfig::default());
    let mut start = lane_at(model.joints.len(), stance_height());
    start.joint_pos = stance(&model);
    reset_all(&mut e, &start);
    let targets = start.joint_pos.clone();
    let weight = model.mass() * 9.81;
    let feet = [model.body_index("left_foot").unwrap(), model.body_index("right_foot").unwrap()];
    for step in 0..100 {
        e.step(0, &targets);
        let s = e.state(0);
        assert!(s.bodies[0].pos.0[2] > 0.7, "fell at control step {step}: {:?}", s.bodies[0].pos);
        for f in feet {
            let foot = &s.bodies[f];
            for x in [-0.05, 0.12] {
                for y in [-0.03, 0.03] {
                    let lowest = (foot.pos + foot.rot.mul_vec(paid_lanes::Vec3([x, y, -0.06]))).0[2] - 0.01;
                    assert!(lowest > -0.002, "sole at {lowest} m at control step {step}");
                }
            }
        }
    }
    let s = e.state(0);
    let load: f64 = feet.iter().map(|&f| s.contact_force[f].norm()).sum();
    assert!((load - weight).abs() < 0.05 * weight, "feet carry {load} N of {weight} N");
    assert!(s.bodies[0].lin_vel.norm() < 0.05);
}
