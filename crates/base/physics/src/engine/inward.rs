//! Second pass, tips to base: articulated inertias, with joint controllers, limits and friction implicit.

use paid_lanes::Real;

use super::articulated::{Articulated, BaseFactor};
use super::group::{Group, JointWork, Work};
use super::layout::{Link, ModelLayout, Visit};
use super::params::{GroupParams, MotorLanes};
use super::phase::phase;
use super::solver::SOLVER;
use super::spatial::Force;
use super::step::Constants;
use super::{outward, soft};

/// What acts on a joint.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Drive<'a, V> {
    /// PD controllers with joint stops and friction, toward these angles.
    Targets(&'a [V]),
    /// These torques alone, for comparisons.
    Torques(&'a [V]),
}

/// The motor of joint `j` and its controller in each lane.
#[inline(always)]
fn motor<V: Real>(link: &Link<V::Scalar>, params: &GroupParams<V>, j: usize) -> MotorLanes<V> {
    let mut motor = MotorLanes {
        armature: V::splat(link.armature),
        stiffness: V::splat(link.stiffness) * params.gain_scale[0],
        damping: V::splat(link.gain_damping) * params.gain_scale[1],
        effort: V::splat(link.effort),
        friction: V::splat(link.friction_loss),
    };
    if let Some(scales) = &params.motor_scale {
        let scale = &scales[j];
        motor.armature *= scale.armature;
        motor.stiffness *= scale.stiffness;
        motor.damping *= scale.damping;
        motor.effort *= scale.effort;
        motor.friction *= scale.friction;
    }
    motor
}

/// Torque of joint `j` at the start of the step and its implicit share: `torque - diagonal * acceleration`, armature included.
#[inline(always)]
fn joint_torque<V: Real>(
    link: &Link<V::Scalar>,
    motor: &MotorLanes<V>,
    pd_implicitness: V,
    q: V,
    qd: V,
    target: V,
    h: V,
) -> (V, V) {
    let zero = V::zero();
    let MotorLanes { armature, stiffness, damping, effort: limit, friction } = *motor;
    // The torque is (1 - s) of the step's start and s of its end.
    let known = pd_implicitness * h;
    let wanted = stiffness.mul_add(known, damping).neg_mul_add(qd, stiffness * (target - q));
    let free = wanted.abs().lt(limit);
    let mut torque = wanted.min(limit).max(-limit);
    let mut diagonal = armature + V::select(free, stiffness.mul_add(h, damping) * known, zero);

    let over = (V::splat(link.range[0]) - q).max(zero) + (V::splat(link.range[1]) - q).min(zero);
    let at_stop = zero.lt(over.abs());
    let stop_stiffness = V::c(SOLVER.joint_stop_stiffness);
    let stop_ahead = stop_stiffness.mul_add(h, V::c(SOLVER.joint_stop_damping));
    let stop = stop_ahead.neg_mul_add(qd, stop_stiffness * over);
    torque += V::select(at_stop, stop, zero);
    diagonal += V::select(at_stop, stop_ahead * h, zero);

    let friction = friction * (qd.abs() + V::c(SOLVER.joint_friction_speed)).recip();
    let viscous = friction + V::splat(link.damping);
    (viscous.neg_mul_add(qd, torque), viscous.mul_add(h, diagonal))
}

/// Passes `art` through a joint to the parent.
#[inline(always)]
fn reduce<V: Real>(art: &mut Articulated<V>, joint: &mut JointWork<V>, torque: V, diagonal: V) {
    let u = art.mul(joint.axis);
    let inv = (joint.axis.dot(u) + diagonal).recip();
    let torque = torque - joint.axis.dot(art.bias);
    let gain = Force { ang: u.ang.scale(inv), lin: u.lin.scale(inv) };
    joint.gain = gain.array();
    joint.inv = inv;
    joint.torque = torque;
    joint.impulse = V::zero();
    joint.pending = V::zero();
    joint.sole_impulse = V::zero();
    art.a.minus_outer(u.ang, gain.ang);
    art.m.minus_outer(u.lin, gain.lin);
    for r in 0..3 {
        for c in 0..3 {
            art.b.0[r][c] = u.ang.0[r].neg_mul_add(gain.lin.0[c], art.b.0[r][c]);
        }
    }
    art.bias = art.bias.plus(gain, torque);
}

phase! {
/// The pass over chain `c`, whose children have been passed.
pub(crate) fn inward<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a mut Work<V>,
    drive: Drive<'a, V>,
    c: usize,
) -> () {
    let h = constants.dt;
    let in_contact = matches!(drive, Drive::Targets(_));
    let chain = layout.chains[c];
    let mut art = w.art[c];
    for j in (chain.first..chain.end).rev() {
        let link = &layout.links[j];
        art.add_rigid(&w.rigid[chain.depth + j - chain.first]);
        if in_contact && link.soft_ground && link.capsules[0] < link.capsules[1] {
            let vel = w.vel[j + 1];
            let forces = &mut w.forces;
            soft::ground_contact(layout, constants, g, j + 1, link.capsules, &w.ends, vel, &mut art, forces);
        }
        let (torque, diagonal) = match drive {
            Drive::Targets(t) => {
                let motor = motor(link, &g.params, j);
                joint_torque(link, &motor, g.params.pd_implicitness, g.q[j], g.qd[j], t[j], h)
            }
            Drive::Torques(t) => (t[j], motor(link, &g.params, j).armature),
        };
        reduce(&mut art, &mut w.joints[j], torque, diagonal);
    }
    match chain.parent {
        Some(p) => w.art[p].add(&art),
        None => w.base_art.add(&art),
    }
}
}

phase! {
/// The base, once all chains have been passed.
pub(crate) fn finish<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a mut Work<V>,
    drive: Drive<'a, V>,
) -> () {
    if matches!(drive, Drive::Targets(_)) {
        let range = layout.base_capsules;
        let vel = w.base.vel;
        soft::ground_contact(layout, constants, g, 0, range, &w.ends, vel, &mut w.base_art, &mut w.forces);
    }
    w.factor = BaseFactor::new(&w.base_art);
    let bias = w.base_art.bias;
    let mut free = Force { ang: -bias.ang, lin: -bias.lin }.array();
    for x in &mut free {
        *x *= constants.dt;
    }
    w.factor.half_solve(&mut free);
    w.base_free = free;
    w.base_impulse = [V::zero(); 6];
    w.base_pending = [V::zero(); 6];
    w.base_sole_impulse = [V::zero(); 6];
}
}

/// Both passes over the whole tree, limb by limb.
#[inline(always)]
pub(crate) fn dynamics<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<'_, V>,
    g: &Group<V>,
    w: &mut Work<V>,
    drive: Drive<'_, V>,
) {
    outward::start(layout, g, w, constants.gravity);
    for &visit in &layout.visits {
        match visit {
            Visit::Outward(c) => outward::outward(layout, g, w, c),
            Visit::Inward(c) => inward(layout, constants, g, w, drive, c),
        }
    }
    finish(layout, constants, g, w, drive);
}

/// Actuator torque of joint `j` at the end of the step: the implicit controller's, within the effort limit `[N m]`.
#[inline(always)]
pub(crate) fn actuator_torque<V: Real>(
    link: &Link<V::Scalar>,
    params: &GroupParams<V>,
    j: usize,
    q: V,
    qd: V,
    target: V,
) -> V {
    let MotorLanes { stiffness, damping, effort: limit, .. } = motor(link, params, j);
    damping.neg_mul_add(qd, stiffness * (target - q)).min(limit).max(-limit)
}
