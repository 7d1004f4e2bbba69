//! An impact in an engine.

use paid_lanes::Real;
use paid_physics::{EnvParams, Simulator};

use super::draw::Impact;

/// An impact is over once the ball has been untouched for this long `[s]`.
const APART_S: f64 = 0.005;
/// No impact takes longer `[s]`.
const LIMIT_S: f64 = 0.2;

/// The ball after an impact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exit {
    /// Velocity `[m/s]`.
    pub velocity: [f64; 3],
    /// Spin, world axes `[rad/s]`.
    pub spin: [f64; 3],
}

/// Runs `impact` in lane 0 of group 0, whose control step is one physics step; `None` if the ball is missed.
pub fn run<V: Real>(sim: &mut impl Simulator<V>, params: &EnvParams, impact: &Impact) -> Option<Exit> {
    let params = EnvParams { gain_scale: params.gain_scale.map(|g| g * impact.gain), ..params.clone() };
    sim.set_params(0, 0, &params);
    sim.reset_lane(0, 0, &impact.state);
    sim.refresh(0);
    let targets: Vec<V> = impact.targets.iter().map(|q| V::c(*q)).collect();
    let dt = sim.control_dt_s();
    let mut last = None;
    for step in 1..=(LIMIT_S / dt).round() as usize {
        let now = step as f64 * dt;
        sim.step(0, &targets);
        let ball = &sim.state(0).ball;
        if ball.touched_by.lane(0) >= 0.0 {
            last = Some(now);
        } else if last.is_some_and(|last| now - last > APART_S - 1e-9) {
            let axes = |v: paid_lanes::Vec3<V>| v.0.map(|x| x.lane(0));
            return Some(Exit { velocity: axes(ball.vel), spin: axes(ball.ang_vel) });
        }
    }
    None
}
