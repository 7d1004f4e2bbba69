//! Robot against itself: the deepest pair of shapes of two chains, pushed apart at velocity level, with friction.

use paid_lanes::{Mask, Real, Vec3};

use super::block::{Block, tangents};
use super::group::{Group, Work};
use super::layout::ModelLayout;
use super::phase::phase;
use super::rows::{Rows, is_body, is_zero};
use super::shapes::Pair;
use super::solver::SOLVER;
use super::spatial::{Motion, length, unit};
use super::step::Constants;
use crate::nearest_points;

/// Contact between two chains.
#[derive(Clone, Debug)]
pub(crate) struct PairTouch<V: Real> {
    /// Half-solved unit impulses along the frame on the first chain, against it on the second (its `base` is unused).
    rows: [Rows<V, 3>; 2],
    pub active: bool,
    bodies: [V; 2],
    /// Two tangents, and the normal away from the second chain.
    frame: [Vec3<V>; 3],
    block: Block<V>,
    target: V,
    on: V,
    /// Velocity of the first surface against the second without contacts, in the frame.
    free: [V; 3],
    /// On the first chain, in the frame.
    impulse: [V; 3],
}

impl<V: Real> PairTouch<V> {
    pub fn new(first: usize, second: usize) -> Self {
        let z = V::zero();
        Self {
            rows: [Rows::new(first), Rows::new(second)],
            active: false,
            bodies: [z; 2],
            frame: [Vec3::zero(); 3],
            block: Block::zero(),
            target: z,
            on: z,
            free: [z; 3],
            impulse: [z; 3],
        }
    }
}

phase! {
/// Finds and prepares the contacts; true if there is one.
pub(crate) fn prepare<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    w: &'a mut Work<V>,
) -> bool {
    let mut found = false;
    let mut touches = core::mem::take(&mut w.pairs);
    for i in 0..touches.len() {
        let touch = &mut touches[i];
        touch.active = prepare_touch(layout, constants, w, i, touch);
        found |= touch.active;
    }
    w.pairs = touches;
    found
}
}

/// Finds and prepares the contact of one pair of chains; false if no lane touches.
#[inline(always)]
fn prepare_touch<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<V>,
    w: &Work<V>,
    index: usize,
    touch: &mut PairTouch<V>,
) -> bool {
    let zero = V::zero();
    let group = &layout.pairs[index];
    let mut gap = V::c(1e3);
    let mut bodies = [zero; 2];
    let mut apart = Vec3::zero();
    let mut surface = Vec3::zero();
    let mut vel = [Motion::zero(); 2];
    for p in 0..group.pairs.len() {
        let Pair { capsules: [i, j], far } = group.pairs[p];
        let (ends_a, ends_b) = (&w.ends[i], &w.ends[j]);
        let between = (ends_a[0] - ends_b[0]) + (ends_a[1] - ends_b[1]);
        if !between.norm2().lt(V::c(far)).any() {
            continue;
        }
        let (a, b) = (&layout.capsules[i], &layout.capsules[j]);
        let length2 = [V::splat(a.length2), V::splat(b.length2)];
        let inv_length2 = [V::splat(a.inv_length2), V::splat(b.inv_length2)];
        let [on_a, on_b] = nearest_points(ends_a, ends_b, length2, inv_length2);
        let d = on_a - on_b;
        let (radius_a, radius_b) = (V::splat(a.radius), V::splat(b.radius));
        let this = length(d) - (radius_a + radius_b);
        let closer = this.lt(gap.min(V::c(SOLVER.limb_horizon_m)));
        // Every step passes here for all pairs: what only contacts need is behind the branch.
        if !closer.any() {
            continue;
        }
        gap = V::select(closer, this, gap);
        apart = Vec3::select(closer, d, apart);
        // Halfway between the surfaces, weighted by the radii.
        let share = V::c(0.5) * (radius_a - radius_b) * (radius_a + radius_b).recip() + V::c(0.5);
        surface = Vec3::select(closer, d.scale_add(V::one() - share, on_b), surface);
        bodies[0] = V::select(closer, V::c(a.body as f64), bodies[0]);
        bodies[1] = V::select(closer, V::c(b.body as f64), bodies[1]);
        for side in 0..2 {
            let v = w.vel[if side == 0 { a.body } else { b.body }];
            vel[side].ang = Vec3::select(closer, v.ang, vel[side].ang);
            vel[side].lin = Vec3::select(closer, v.lin, vel[side].lin);
        }
    }
    if !gap.lt(V::c(SOLVER.limb_horizon_m)).any() {
        return false;
    }
    let n = unit(apart);
    let relative = vel[0].at(surface) - vel[1].at(surface);
    let speed = relative.dot(n);
    let on = speed.min(zero).mul_add(constants.dt, gap).lt(V::c(SOLVER.limb_margin_m));
    if !on.any() {
        return false;
    }
    let [t1, t2] = tangents(n);
    touch.on = V::select(on, V::one(), zero);
    touch.bodies = bodies;
    touch.frame = [t1, t2, n];
    touch.impulse = [zero; 3];
    touch.target = constants.approach.target(gap, SOLVER.limb_slop_m, zero, zero, SOLVER.limb_max_push);
    let [first, second] = &mut touch.rows;
    let paths = [&layout.paths[group.chains[0]][..], &layout.paths[group.chains[1]][..]];
    first.carry_to_base(w, paths[0], bodies[0], surface, &touch.frame);
    second.carry_to_base(w, paths[1], bodies[1], surface, &[-t1, -t2, -n]);
    for r in 0..6 {
        for c in 0..3 {
            first.base[r][c] += second.base[r][c];
        }
    }
    first.solve_base(w);
    // Lanes that do not touch have nothing there.
    let least = V::c(1e-6);
    let [of_first, of_second] = [first.couplings(w, paths[0]), second.joint_couplings(w, paths[1])];
    let mut couplings = [least, least, least, zero, zero, zero];
    for k in 0..6 {
        couplings[k] += of_first[k] + of_second[k];
    }
    touch.block = Block::new(couplings);
    let mut free = [relative.dot(t1), relative.dot(t2), speed];
    first.free_joints(w, paths[0], constants.dt, &mut free);
    second.free_joints(w, paths[1], constants.dt, &mut free);
    first.free_base(w, &mut free);
    touch.free = free;
    true
}

/// One improvement of every contact; false if no impulse changed.
#[inline(always)]
pub(crate) fn sweep<V: Real>(layout: &ModelLayout<V::Scalar>, g: &Group<V>, w: &mut Work<V>) -> bool {
    let mut changed = false;
    let friction = g.params.robot.friction();
    let mut touches = core::mem::take(&mut w.pairs);
    for i in 0..touches.len() {
        let touch = &mut touches[i];
        if !touch.active {
            continue;
        }
        let [a, b] = layout.pairs[i].chains;
        let paths = [&layout.paths[a][..], &layout.paths[b][..]];
        let [first, second] = &touch.rows;
        let mut v = touch.free;
        first.pushed_joints(w, paths[0], &mut v);
        second.pushed_joints(w, paths[1], &mut v);
        first.pushed_base(w, &mut v);
        let change = touch.block.solve(v, touch.target, touch.on, friction, &mut touch.impulse).change;
        if is_zero(&change) {
            continue;
        }
        changed = true;
        first.push_joints(w, paths[0], &change);
        second.push_joints(w, paths[1], &change);
        first.push_base(w, &change);
    }
    w.pairs = touches;
    changed
}

/// Reports the contact forces.
#[inline(always)]
pub(crate) fn finish<V: Real>(layout: &ModelLayout<V::Scalar>, constants: &Constants<V>, w: &mut Work<V>) {
    for i in 0..w.pairs.len() {
        let touch = &w.pairs[i];
        if !touch.active {
            continue;
        }
        let (k, [x, y, z], [t1, t2, n]) = (constants.inv_dt, touch.impulse, touch.frame);
        let force = t1.scale_add(x * k, t2.scale_add(y * k, n.scale(z * k)));
        for side in 0..2 {
            let chain = layout.chains[layout.pairs[i].chains[side]];
            let f = if side == 0 { force } else { -force };
            for b in chain.first + 1..chain.end + 1 {
                w.forces.add(b, f, is_body(touch.bodies[side], b));
            }
        }
    }
}
