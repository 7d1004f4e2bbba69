//! Soles on the ground, at velocity level: sweeps over the sole points on the inverse inertia of the two feet.

use paid_lanes::{Mask, Mat3, Real, Vec3};

use super::block::{Friction, ground_tangents};
use super::foot::FreeBase;
use super::group::{Group, Work};
use super::layout::ModelLayout;
use super::phase::phase;
use super::solver::SOLVER;
use super::spatial::{Force, Motion, dot6, splat3};
use super::step::Constants;

phase! {
/// How the feet answer to impulses, and their velocities without contacts.
pub(crate) fn respond<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a mut Work<V>,
) -> () {
    // The base's linear velocity is that of its origin, which moves: spatial to classical acceleration.
    w.gyro = g.omega.cross(g.vel).scale(constants.dt);
    let mut free = FreeBase { scaled: w.base_free, dt: constants.dt };
    for i in 0..6 {
        free.scaled[i] *= w.factor.inv[i];
    }
    for f in 0..2 {
        let chain = layout.chains[layout.legs[f]];
        let joints = &w.joints[chain.first..chain.end];
        let foot = &mut w.feet[f];
        foot.half_solve(0, joints, &w.factor);
        foot.half_solve(3, joints, &w.factor);
        foot.build_inverse(joints, &w.factor);
        foot.free_velocity(w.kin[layout.legs[f]].vel, w.gyro, joints, &free);
    }
    let [left, right] = &w.feet;
    for r in 0..6 {
        let mut row = [V::zero(); 6];
        for k in 0..6 {
            let x = left.base[k][r] * w.factor.inv[k];
            for c in 0..6 {
                row[c] = x.mul_add(right.base[k][c], row[c]);
            }
        }
        w.cross[r] = row;
    }
}
}

phase! {
/// Prepares the sole points for the sweeps.
pub(crate) fn prepare<'a, V, const PLANE: bool>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a mut Work<V>,
) -> () {
    let zero = V::zero();
    let restitution = g.params.robot_ground.restitution;
    let spring = &g.params.sole_spring;
    let needs_speed = spring.any || zero.lt(restitution).any();
    let shape = g.params.sole_shape.as_ref();
    let Work { kin, soles, feet, .. } = w;
    for f in 0..2 {
        let kin = &kin[layout.legs[f]];
        for i in 0..layout.soles.len() {
            let (center, radius) = &layout.soles[i][f];
            let mut radius = V::splat(*radius);
            let mut center = splat3(center);
            if let Some(shape) = shape {
                let frame = &layout.sole_frames[i][f];
                center = splat3(&frame.ahead).scale_add(shape.length, center);
                center = splat3(&frame.left).scale_add(shape.width, center);
                center = splat3(&frame.up).scale_add(shape.rounding, center);
                radius += shape.rounding;
            }
            let center = kin.place(center);
            let sole = &mut soles[i][f];
            let gap;
            if PLANE {
                sole.point = Vec3([center.0[0], center.0[1], center.0[2] - radius]);
                gap = g.pos.0[2] + sole.point.0[2];
            } else {
                let x = center.0[0] + g.pos.0[0];
                let y = center.0[1] + g.pos.0[1];
                let (height, n) = constants.ground.at(x, y, &g.params);
                let [t1, t2] = ground_tangents(n);
                sole.frame = Mat3([t1.0, t2.0, n.0]).transpose();
                sole.point = center - n.scale(radius);
                gap = (g.pos.0[2] + center.0[2] - height).mul_add(n.0[2], -radius);
            }
            sole.build_response::<PLANE>(&feet[f].inverse);
            let start = if needs_speed { sole.in_frame::<PLANE>(kin.vel.at(sole.point)) } else { [zero; 3] };
            let speed = start[2];
            sole.target = constants.approach.target(gap, SOLVER.sole_slop_m, speed, restitution, SOLVER.sole_max_push);
            if spring.any {
                let soft = spring.target(gap, speed, constants.dt, SOLVER.sole_soft_reach_m);
                let is_soft = spring.is_soft();
                sole.target = V::select(is_soft, soft.speed, sole.target);
                let keep = V::select(is_soft, soft.slide, zero);
                sole.slide = [start[0] * keep, start[1] * keep];
            }
            let on = V::select(gap.lt(V::c(SOLVER.sole_reach_m)), V::one(), zero);
            sole.on = on;
            let warm = &g.warm[i][f];
            sole.impulse = [warm[0] * on, warm[1] * on, warm[2] * on];
        }
    }
    for f in 0..2 {
        let total = wrench::<V, PLANE>(w, f);
        w.feet[f].impulse = Force::from_array(total);
        w.feet[f].push(total);
        w.feet[f].friction = g.params.robot_ground.static_friction;
        couple(w, f, total);
    }
}
}

/// Sum of the sole impulses of a foot about the base's origin.
#[inline(always)]
fn wrench<V: Real, const PLANE: bool>(w: &Work<V>, f: usize) -> [V; 6] {
    let mut sum = Force::zero();
    for i in 0..w.soles.len() {
        let sole = &w.soles[i][f];
        let impulse = sole.world_impulse::<PLANE>();
        sum.ang = sole.point.cross_add(impulse, sum.ang);
        sum.lin += impulse;
    }
    sum.array()
}

/// Passes an impulse on foot `f` through the base to the other foot's velocity.
#[inline(always)]
fn couple<V: Real>(w: &mut Work<V>, f: usize, change: [V; 6]) {
    let mut v = w.feet[1 - f].vel.array();
    for r in 0..6 {
        for c in 0..6 {
            let k = if f == 0 { w.cross[c][r] } else { w.cross[r][c] };
            v[r] = k.mul_add(change[c], v[r]);
        }
    }
    w.feet[1 - f].vel = Motion::from_array(v);
}

phase! {
/// One sweep over all sole points. The feet alternate: their dependency chains hide each other's latency.
///
/// A foot sticks or slides as a whole: points that slid one by one would hand their load to the next until all slide.
/// Where `decide` is set, what the sweep finds holds for the rest of the step.
pub(crate) fn sweep<'a, V, const PLANE: bool>(g: &'a Group<V>, w: &'a mut Work<V>, decide: bool) -> () {
    let surface = g.params.robot_ground;
    let soft = g.params.sole_spring.any;
    let mut vel = [w.feet[0].vel.array(), w.feet[1].vel.array()];
    let mut wanted = [[V::zero(); 3]; 2];
    for i in 0..w.soles.len() {
        for f in 0..2 {
            let sole = &mut w.soles[i][f];
            let mut v = sole.in_frame::<PLANE>(Motion::from_array(vel[f]).at(sole.point));
            if soft {
                v[0] -= sole.slide[0];
                v[1] -= sole.slide[1];
            }
            let friction = Friction { stick: w.feet[f].friction, slide: w.feet[f].friction };
            let improved = sole.block.solve(v, sole.target, sole.on, friction, &mut sole.impulse);
            let change = improved.change;
            wanted[f][0] += improved.wanted[0];
            wanted[f][1] += improved.wanted[1];
            wanted[f][2] += sole.impulse[2];
            for r in 0..6 {
                let row = &sole.response[r];
                let x = row[1].mul_add(change[1], row[0].mul_add(change[0], vel[f][r]));
                vel[f][r] = row[2].mul_add(change[2], x);
            }
        }
    }
    for f in 0..2 {
        w.feet[f].vel = Motion::from_array(vel[f]);
        if decide {
            let [x, y, normal] = wanted[f];
            let most = surface.static_friction * normal;
            let sticks = x.mul_add(x, y * y).le(most * most);
            w.feet[f].friction = V::select(sticks, surface.static_friction, surface.dynamic_friction);
        }
    }
    for f in 0..2 {
        let total = wrench::<V, PLANE>(w, f);
        let mut change = total;
        let before = w.feet[f].impulse.array();
        for c in 0..6 {
            change[c] -= before[c];
        }
        w.feet[f].impulse = Force::from_array(total);
        couple(w, f, change);
    }
}
}

/// Adds the feet's half-solved impulses to joints and base; keeps the warm start and the contact forces.
#[inline(always)]
pub(crate) fn finish<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<V>,
    g: &mut Group<V>,
    w: &mut Work<V>,
) {
    for f in 0..2 {
        let chain = layout.chains[layout.legs[f]];
        let total = w.feet[f].impulse.array();
        for j in chain.first..chain.end {
            let y = &w.feet[f].joints[j - chain.first];
            w.joints[j].impulse += dot6(y, &total);
        }
        for r in 0..6 {
            w.base_impulse[r] += dot6(&w.feet[f].base[r], &total);
        }
        for i in 0..w.soles.len() {
            g.warm[i][f] = w.soles[i][f].impulse;
        }
        w.forces.add(chain.end, w.feet[f].impulse.lin, constants.inv_dt);
    }
}
