//! One physics step of a group.

use paid_lanes::Real;

use super::block::Approach;
use super::ground::Ground;
use super::group::{Group, Work};
use super::inward::{Drive, dynamics};
use super::layout::ModelLayout;
use super::phase::phase;
use super::spatial::{Motion, dot6};
use super::{ball, feet, pairs, rows, touch};
use crate::SceneConfig;

/// The scene's numbers in lane form.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Constants<'a, V: Real> {
    pub dt: V,
    pub inv_dt: V,
    pub gravity: V,
    pub max_joint_speed: V,
    pub highest_ground: V,
    pub approach: Approach<V>,
    pub ground: &'a Ground<V::Scalar>,
    pub sweeps: usize,
    pub ball: bool,
}

impl<'a, V: Real> Constants<'a, V> {
    #[inline(always)]
    pub fn new(scene: &SceneConfig, ground: &'a Ground<V::Scalar>) -> Self {
        let dt = V::c(scene.physics_dt_s);
        let inv_dt = V::c(1.0 / scene.physics_dt_s);
        Self {
            dt,
            inv_dt,
            gravity: V::c(scene.gravity),
            max_joint_speed: V::c(scene.max_joint_speed),
            highest_ground: V::c(ground.highest()),
            approach: Approach { inv_dt, dt, bounce_threshold: V::c(scene.bounce_threshold) },
            ground,
            sweeps: scene.solver_sweeps,
            ball: scene.ball,
        }
    }
}

/// Advances a group by one physics step toward the joint targets.
#[inline(always)]
pub(crate) fn physics_step<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<'_, V>,
    g: &mut Group<V>,
    w: &mut Work<V>,
    targets: &[V],
) {
    let plane = constants.ground.is_plane();
    w.forces.clear();
    dynamics(layout, constants, g, w, Drive::Targets(targets));
    feet::respond(layout, constants, g, w);
    if plane {
        feet::prepare::<V, true>(layout, constants, g, w);
    } else {
        feet::prepare::<V, false>(layout, constants, g, w);
    }
    let mut others = pairs::prepare(layout, constants, w);
    if constants.ball {
        ball::prepare_ground(constants, g, w);
        others |= touch::prepare(layout, constants, g, w);
    }
    for i in 0..constants.sweeps {
        let decide = i + 1 == constants.sweeps.div_ceil(2);
        if plane {
            feet::sweep::<V, true>(g, w, decide);
        } else {
            feet::sweep::<V, false>(g, w, decide);
        }
        if others {
            sweep_others(layout, g, w);
        }
        if constants.ball {
            ball::sweep_ground(g, w);
        }
    }
    finish(layout, constants, g, w);
}

phase! {
/// One improvement of all contacts but the soles', and of the feet's velocities after it.
fn sweep_others<'a, V>(layout: &'a ModelLayout<V::Scalar>, g: &'a Group<V>, w: &'a mut Work<V>) -> () {
    rows::spread_soles(layout, w);
    let changed = pairs::sweep(layout, g, w);
    if touch::sweep(layout, g, w) || changed {
        rows::push_feet(layout, w);
    }
}
}

phase! {
/// Third pass, base to tips: new velocities and positions from bias, torques and contact impulses.
fn finish<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a mut Group<V>,
    w: &'a mut Work<V>,
) -> () {
    feet::finish(layout, constants, g, w);
    pairs::finish(layout, constants, w);
    if constants.ball {
        ball::finish(layout, constants, g, w);
    }
    let h = constants.dt;
    let mut change = w.base_free;
    for i in 0..6 {
        change[i] += w.base_impulse[i];
    }
    w.factor.finish(&mut change);
    let base = Motion::from_array(change);
    g.omega += base.ang;
    g.vel += base.lin + w.gyro;
    let limit = constants.max_joint_speed;
    for c in 0..layout.chains.len() {
        let chain = layout.chains[c];
        let mut change = chain.parent.map_or(base, |p| w.change[p]);
        for j in chain.first..chain.end {
            let joint = &w.joints[j];
            let own = joint.torque.mul_add(h, joint.impulse) * joint.inv;
            let qd = own - dot6(&joint.gain, &change.array());
            change = change.plus(joint.axis, qd);
            let qd = (g.qd[j] + qd).min(limit).max(-limit);
            g.qd[j] = qd;
            g.q[j] = qd.mul_add(h, g.q[j]);
        }
        w.change[c] = change;
    }
    g.pos = g.vel.scale_add(h, g.pos);
    g.quat = g.quat.integrate(g.omega, h);
}
}
