//! First pass, base to tips: poses, velocities, rigid inertias and bias forces.

use paid_lanes::{Real, Vec3};

use super::articulated::Articulated;
use super::group::{Group, Work};
use super::layout::{Link, ModelLayout};
use super::phase::phase;
use super::spatial::{Kin, Motion, Rigid, splat_sym, splat3};

/// Pose and motion of the base; gravity enters as an upward acceleration of the world.
#[inline(always)]
pub(crate) fn base_kin<V: Real>(g: &Group<V>, gravity: V) -> Kin<V> {
    Kin {
        rot: g.quat.to_mat(),
        pos: Vec3::zero(),
        vel: Motion { ang: g.omega, lin: g.vel },
        acc: Motion { ang: Vec3::zero(), lin: Vec3::new(V::zero(), V::zero(), -gravity) },
    }
}

/// Inertia of the base with each lane's mass scale and shift of the center of mass.
#[inline(always)]
pub(crate) fn base_rigid<V: Real>(layout: &ModelLayout<V::Scalar>, g: &Group<V>, kin: &Kin<V>) -> Rigid<V> {
    let b = &layout.base;
    let com = splat3(&b.com) + g.params.base_com_offset;
    let mut rigid = Rigid::new(V::splat(b.mass), com, splat_sym(&b.inertia), kin);
    if let Some(scale) = &g.params.mass_scale {
        rigid.scale(scale[0]);
    }
    rigid
}

/// Sines and cosines of all joint angles: in a loop of their own, where one joint does not wait for another.
#[inline(always)]
pub(crate) fn trigonometry<V: Real>(g: &Group<V>, w: &mut Work<V>) {
    for j in 0..w.trig.len() {
        let (s, c) = g.q[j].sin_cos();
        w.trig[j] = [s, c];
    }
}

/// Steps over joint `link`: turns the pose of `kin` from the parent's into the link's and returns the joint's motion axis.
#[inline(always)]
fn turn<V: Real, const AXIS: usize>(link: &Link<V::Scalar>, kin: &mut Kin<V>, [s, c]: [V; 2]) -> Motion<V> {
    kin.pos = kin.rot.mul_vec(splat3(&link.pos)) + kin.pos;
    if link.turned {
        let m = [splat3(&link.rot[0]).0, splat3(&link.rot[1]).0, splat3(&link.rot[2]).0];
        kin.rot = kin.rot.mul_mat(&paid_lanes::Mat3(m));
    }
    let (a, b) = ((AXIS + 1) % 3, (AXIS + 2) % 3);
    for r in 0..3 {
        let (x, y) = (kin.rot.0[r][a], kin.rot.0[r][b]);
        kin.rot.0[r][a] = s.mul_add(y, c * x);
        kin.rot.0[r][b] = s.neg_mul_add(x, c * y);
    }
    let ang = kin.rot.col(AXIS);
    Motion { ang, lin: kin.pos.cross(ang) }
}

/// [`turn`] about the link's own axis.
#[inline(always)]
pub(crate) fn over_joint<V: Real>(link: &Link<V::Scalar>, kin: &mut Kin<V>, trig: [V; 2]) -> Motion<V> {
    match link.axis {
        0 => turn::<V, 0>(link, kin, trig),
        1 => turn::<V, 1>(link, kin, trig),
        _ => turn::<V, 2>(link, kin, trig),
    }
}

/// Adds the joint's motion to the velocity and the velocity-product acceleration of `kin`.
#[inline(always)]
fn accelerate<V: Real>(kin: &mut Kin<V>, axis: Motion<V>, qd: V) {
    let (ang, lin) = (axis.ang.scale(qd), axis.lin.scale(qd));
    let v = kin.vel;
    kin.acc.ang = v.ang.cross_add(ang, kin.acc.ang);
    kin.acc.lin = v.lin.cross_add(ang, v.ang.cross_add(lin, kin.acc.lin));
    kin.vel = v.plus(axis, qd);
}

/// Where the shapes of a body are.
#[inline(always)]
fn place_capsules<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    range: [usize; 2],
    kin: &Kin<V>,
    ends: &mut [[Vec3<V>; 2]],
) {
    for i in range[0]..range[1] {
        let capsule = &layout.capsules[i];
        let first = kin.place(splat3(&capsule.ends[0]));
        let second = if capsule.sphere { first } else { kin.place(splat3(&capsule.ends[1])) };
        ends[i] = [first, second];
    }
}

phase! {
/// The base, and what all chains need.
pub(crate) fn start<'a, V>(layout: &'a ModelLayout<V::Scalar>, g: &'a Group<V>, w: &'a mut Work<V>, gravity: V) -> () {
    trigonometry(g, w);
    w.base = base_kin(g, gravity);
    w.vel[0] = w.base.vel;
    place_capsules(layout, layout.base_capsules, &w.base, &mut w.ends);
    w.base_art = Articulated::zero();
    w.base_art.add_rigid(&base_rigid(layout, g, &w.base));
}
}

phase! {
/// The pass over chain `c`, whose parent chain has been passed.
pub(crate) fn outward<'a, V>(layout: &'a ModelLayout<V::Scalar>, g: &'a Group<V>, w: &'a mut Work<V>, c: usize) -> () {
    let chain = layout.chains[c];
    let mut kin = chain.parent.map_or(w.base, |p| w.kin[p]);
    for j in chain.first..chain.end {
        let link = &layout.links[j];
        let axis = over_joint(link, &mut kin, w.trig[j]);
        accelerate(&mut kin, axis, g.qd[j]);
        w.joints[j].axis = axis;
        let b = &link.inertial;
        let mut rigid = Rigid::new(V::splat(b.mass), splat3(&b.com), splat_sym(&b.inertia), &kin);
        if let Some(scale) = &g.params.mass_scale {
            rigid.scale(scale[j + 1]);
        }
        w.rigid[chain.depth + j - chain.first] = rigid;
        w.vel[j + 1] = kin.vel;
        place_capsules(layout, link.capsules, &kin, &mut w.ends);
    }
    w.kin[c] = kin;
    w.art[c] = Articulated::zero();
}
}
