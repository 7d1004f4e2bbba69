//! An impact in an engine.

use paid_lanes::Real;
use paid_physics::{EnvParams, Simulator};
use serde::Serialize;

use super::draw::Impact;

/// An impact is over once the ball has been untouched for so long `[s]`.
const APART_S: f64 = 0.005;
/// No impact takes longer `[s]`.
const LIMIT_S: f64 = 0.2;

/// The ball after an impact.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Exit {
    /// Velocity `[m/s]`.
    pub velocity: [f64; 3],
    /// Spin, world axes `[rad/s]`.
    pub spin: [f64; 3],
    /// From the first to the last step with a force `[s]`.
    pub contact_s: f64,
}

/// Runs `impact` in lane 0 of group 0, whose control step is one physics step; `None` if the ball is missed.
pub fn run<V: Real>(sim: &mut impl Simulator<V>, params: &EnvParams, impact: &Impact) -> Option<Exit> {
    let params = EnvParams { gain_scale: params.gain_scale.map(|g| g * impact.gain), ..params.clone() };
    sim.set_params(0, 0, &params);
    sim.reset_lane(0, 0, &impact.state);
    sim.refresh(0);
    let targets: Vec<V> = impact.targets.iter().map(|q| V::c(*q)).collect();
    let dt = sim.control_dt_s();
    let (mut first, mut last) = (None, 0.0);
    for step in 1..=(LIMIT_S / dt).round() as usize {
        let now = step as f64 * dt;
        sim.step(0, &targets);
        let ball = &sim.state(0).ball;
        if ball.touched_by.lane(0) >= 0.0 {
            first.get_or_insert(now - dt);
            last = now;
        } else if let Some(first) = first.filter(|_| now - last > APART_S - 1e-9) {
            let axes = |v: paid_lanes::Vec3<V>| v.0.map(|x| x.lane(0));
            return Some(Exit {
                velocity: axes(ball.vel),
                spin: axes(ball.ang_vel),
                contact_s: last - first,
            });
        }
    }
    None
}
