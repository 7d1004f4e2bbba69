//! What the task sees after a control step.

use paid_lanes::{Mat3, Real, Vec3};

use super::group::{Group, Work};
use super::inward::actuator_torque;
use super::layout::ModelLayout;
use super::outward::{base_kin, over_joint, trigonometry};
use super::phase::phase;
use super::spatial::{Kin, splat3};
use crate::{BodyState, GroupState};

#[inline(always)]
fn body_state<V: Real>(kin: &Kin<V>, origin: Vec3<V>, com: Vec3<V>, frame: Option<Mat3<V>>) -> BodyState<V> {
    let lin_vel = kin.vel.at(kin.pos);
    let arm = kin.rot.mul_vec(com);
    BodyState {
        pos: kin.pos + origin,
        rot: match frame {
            Some(f) => kin.rot.mul_mat(&f.transpose()),
            None => kin.rot,
        },
        lin_vel,
        com_vel: kin.vel.ang.cross_add(arm, lin_vel),
        ang_vel: kin.vel.ang,
    }
}

phase! {
/// Writes joints, bodies and ball from the state.
pub(crate) fn poses<'a, V>(layout: &'a ModelLayout<V::Scalar>, g: &'a mut Group<V>, w: &'a mut Work<V>) -> () {
    trigonometry(g, w);
    let base = base_kin(g, V::zero());
    let com = splat3(&layout.base.com) + g.params.base_com_offset;
    g.state.bodies[0] = body_state(&base, g.pos, com, None);
    for c in 0..layout.chains.len() {
        let chain = layout.chains[c];
        let mut kin = chain.parent.map_or(base, |p| w.kin[p]);
        for j in chain.first..chain.end {
            let link = &layout.links[j];
            let axis = over_joint(link, &mut kin, w.trig[j]);
            kin.vel = kin.vel.plus(axis, g.qd[j]);
            let frame = link.report.map(|f| Mat3([splat3(&f[0]).0, splat3(&f[1]).0, splat3(&f[2]).0]));
            g.state.bodies[j + 1] = body_state(&kin, g.pos, splat3(&link.inertial.com), frame);
            g.state.joint_pos[j] = g.q[j];
            g.state.joint_vel[j] = g.qd[j];
        }
        w.kin[c] = kin;
    }
    ball(g);
}
}

/// Writes the ball from the state.
#[inline(always)]
pub(crate) fn ball<V: Real>(g: &mut Group<V>) {
    let ball = &mut g.state.ball;
    ball.pos = g.ball_pos;
    ball.vel = g.ball_vel;
    ball.ang_vel = g.ball_omega;
}

/// Actuator torques at the end of the last physics step.
#[inline(always)]
pub(crate) fn torques<V: Real>(layout: &ModelLayout<V::Scalar>, g: &mut Group<V>, targets: &[V]) {
    for j in 0..layout.links.len() {
        g.state.joint_torque[j] =
            actuator_torque(&layout.links[j], &g.params, j, g.q[j], g.qd[j], targets[j]);
    }
}

/// Clears what is a maximum over the control step.
#[inline(always)]
pub(crate) fn start<V: Real>(g: &mut Group<V>) {
    for force in &mut g.state.contact_force {
        *force = Vec3::zero();
    }
    let ball = &mut g.state.ball;
    ball.robot_force = Vec3::zero();
    ball.ground_force = Vec3::zero();
    ball.touched_by = V::c(-1.0);
}

/// Takes the forces of a physics step into the maxima.
#[inline(always)]
pub(crate) fn forces<V: Real>(g: &mut Group<V>, w: &Work<V>) {
    for (b, contact) in g.state.contact_force.iter_mut().enumerate() {
        if let Some(force) = w.forces.on(b) {
            *contact = Vec3::select(force.norm2().gt(contact.norm2()), force, *contact);
        }
    }
}

/// Clears the contact reports of reset lanes.
pub(crate) fn clear_lane<V: Real>(state: &mut GroupState<V>, lane: usize) {
    let forces = state.contact_force.iter_mut().flat_map(|force| &mut force.0);
    for x in forces.chain(&mut state.joint_torque) {
        x.set_lane(lane, 0.0);
    }
    state.ball.robot_force.set_lane(lane, [0.0; 3]);
    state.ball.ground_force.set_lane(lane, [0.0; 3]);
    state.ball.touched_by.set_lane(lane, -1.0);
}
