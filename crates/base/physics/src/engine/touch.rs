//! Contacts of ball and robot, at velocity level.

use paid_lanes::{Mask, Real, Vec3};

use super::block::{Block, pyramid_tangents, tangents};
use super::group::{Group, Work};
use super::layout::ModelLayout;
use super::phase::phase;
use super::plate::Rounded;
use super::rows::{Rows, is_body, is_zero};
use super::solver::SOLVER;
use super::spatial::{Motion, length, unit};
use super::step::Constants;
use super::twist::Twist;

/// Contact of the ball with the nearest shape of a chain.
#[derive(Clone, Debug)]
pub(crate) struct BallTouch<V: Real> {
    rows: Rows<V, 3>,
    /// Some lane is in contact.
    pub active: bool,
    /// In a leg's second slot: the body that its first slot touches, -1 for none.
    other_slot: V,
    /// The touched body of each lane.
    pub body: V,
    pub frame: [Vec3<V>; 3],
    block: Block<V>,
    target: V,
    on: V,
    /// Velocity of the robot's surface without contacts, in the frame.
    free: [V; 3],
    /// On the ball, in the frame.
    pub impulse: [V; 3],
    /// Where a soft contact leaves the ball, beyond the straight integration, along the normal `[m]`.
    pub shift: V,
    /// Sliding velocity that a soft contact leaves.
    slide: [V; 2],
    twist: Twist<V>,
}

impl<V: Real> BallTouch<V> {
    pub fn new(joints: usize) -> Self {
        let z = V::zero();
        Self {
            rows: Rows::new(joints),
            active: false,
            other_slot: z,
            body: z,
            frame: [Vec3::zero(); 3],
            block: Block::zero(),
            target: z,
            on: z,
            free: [z; 3],
            impulse: [z; 3],
            shift: z,
            slide: [z; 2],
            twist: Twist::zero(),
        }
    }
}

/// The path of touch slot `slot` (0 is the base, then the chains, then the legs again), its shapes, and its bodies.
#[inline(always)]
pub(crate) fn slot_path<S: paid_lanes::Scalar>(
    layout: &ModelLayout<S>,
    slot: usize,
) -> (&[usize], [usize; 2], [usize; 2]) {
    if slot == 0 {
        return (&[], layout.base_capsules, [0, 1]);
    }
    let index =
        if slot <= layout.chains.len() { slot - 1 } else { layout.legs[slot - 1 - layout.chains.len()] };
    let chain = layout.chains[index];
    let shapes = [layout.links[chain.first].capsules[0], layout.links[chain.end - 1].capsules[1]];
    (&layout.paths[index], shapes, [chain.first + 1, chain.end + 1])
}

/// The foot of slot `slot` and its shape, if it has one and some lane's feet are not the model's.
#[inline(always)]
fn flat_foot<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    g: &Group<V>,
    w: &Work<V>,
    slot: usize,
) -> Option<(usize, Rounded<V>)> {
    let flatness = g.params.foot_flatness?;
    let chain = if slot > layout.chains.len() {
        layout.legs[slot - 1 - layout.chains.len()]
    } else {
        slot.checked_sub(1)?
    };
    let plate = layout.plates[layout.legs.iter().position(|leg| *leg == chain)?].as_ref()?;
    let radius = V::splat(layout.capsules[plate.capsule].radius);
    Some((plate.capsule, plate.at(flatness, w.ends[plate.capsule], radius, &w.kin[chain].rot)))
}

/// Finds and prepares the contacts between ball and robot; true if there is one.
#[inline(always)]
pub(crate) fn prepare<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<V>,
    g: &Group<V>,
    w: &mut Work<V>,
) -> bool {
    let mut found = false;
    let center = g.ball_pos - g.pos;
    let reach = V::c(layout.reach) + g.params.ball.radius;
    let near = center.norm2().lt(reach * reach).any();
    let mut touches = core::mem::take(&mut w.touches);
    let first = 1 + layout.chains.len();
    let any_soft = g.params.ball_robot_spring.any;
    for slot in 0..touches.len() {
        // Soft contacts last, so the ball may lie on foot and shin at once: the second body of a leg has a slot of its own.
        let mut look = near;
        let mut other_slot = V::c(-1.0);
        if slot >= first {
            let touch = &touches[1 + layout.legs[slot - first]];
            look &= any_soft && touch.active;
            other_slot = V::select(V::c(0.5).lt(touch.on), touch.body, other_slot);
        }
        let touch = &mut touches[slot];
        touch.other_slot = other_slot;
        touch.active = look && prepare_slot(layout, constants, g, w, slot, center, touch);
        found |= touch.active;
    }
    w.touches = touches;
    found
}

phase! {
/// Finds and prepares the contact of one slot; false if no lane touches. In a leg's second slot soft lanes alone
/// touch, and another body than in its first.
fn prepare_slot<'a, V>(
    layout: &'a ModelLayout<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a Work<V>,
    slot: usize,
    center: Vec3<V>,
    touch: &'a mut BallTouch<V>,
) -> bool {
    let zero = V::zero();
    let (path, shapes, bodies) = slot_path(layout, slot);
    let ball = &g.params.ball;
    let second = slot > layout.chains.len();
    let flat_foot = flat_foot(layout, g, w, slot);
    let mut gap = V::c(1e3);
    let mut axis_point = Vec3::zero();
    let mut shape_radius = zero;
    let mut body = V::c(bodies[0] as f64);
    for i in shapes[0]..shapes[1] {
        let capsule = &layout.capsules[i];
        let [a, b] = w.ends[i];
        let (nearest, radius) = match &flat_foot {
            Some((foot, shape)) if *foot == i => (shape.nearest(center), shape.radius),
            _ => {
                let along = b - a;
                let t = ((center - a).dot(along) * V::splat(capsule.inv_length2)).clamp(zero, V::one());
                (along.scale_add(t, a), V::splat(capsule.radius))
            }
        };
        let d = center - nearest;
        let mut this = length(d) - (radius + ball.radius);
        if second {
            this = V::select((touch.other_slot - V::c(capsule.body as f64)).abs().lt(V::c(0.5)), V::c(1e3), this);
        }
        let closer = this.lt(gap);
        gap = V::select(closer, this, gap);
        axis_point = Vec3::select(closer, nearest, axis_point);
        shape_radius = V::select(closer, radius, shape_radius);
        body = V::select(closer, V::c(capsule.body as f64), body);
    }
    let near = gap.lt(V::c(SOLVER.ball_horizon_m));
    if !near.any() {
        return false;
    }
    let mut vel = Motion::zero();
    for b in bodies[0]..bodies[1] {
        vel = vel.plus(w.vel[b], is_body(body, b));
    }
    let d = center - axis_point;
    let mut n = unit(d);
    let spring = &g.params.ball_robot_spring;
    if spring.any {
        // A soft contact lasts while the ball rolls about the shape: its normal is that of the middle of the step.
        let half = V::c(0.5) * constants.dt;
        let later = unit((g.ball_vel - vel.at(axis_point)).scale_add(half, d));
        n = Vec3::select(spring.is_soft(), later, n);
    }
    let point = n.scale_add(shape_radius, axis_point);
    let robot = vel.at(point);
    let lever = n.scale(-ball.radius);
    let start = g.ball_omega.cross_add(lever, g.ball_vel) - robot;
    let speed = start.dot(n);
    let on = speed.min(zero).mul_add(constants.dt, gap).lt(V::c(SOLVER.ball_margin_m)).and(near);
    let on = if second { on.and(spring.is_soft()).and(zero.le(touch.other_slot)) } else { on };
    if !on.any() {
        return false;
    }
    let [mut t1, mut t2] = tangents(n);
    if let Some(cone) = &g.params.cone {
        let [p1, p2] = pyramid_tangents(n);
        let has = zero.lt(cone.pyramid);
        (t1, t2) = (Vec3::select(has, p1, t1), Vec3::select(has, p2, t2));
    }
    let frame = [t1, t2, n];
    touch.body = body;
    touch.frame = frame;
    touch.on = V::select(on, V::one(), zero);
    touch.impulse = [zero; 3];
    touch.target = constants.approach.target(gap, SOLVER.ball_slop_m, speed, g.params.ball_robot.restitution, SOLVER.ball_max_push);
    touch.slide = [zero; 2];
    touch.shift = zero;
    let mut keep = zero;
    if spring.any {
        let soft = spring.target(gap, speed, constants.dt, SOLVER.ball_soft_reach_m);
        let is_soft = spring.is_soft();
        touch.target = V::select(is_soft, soft.speed, touch.target);
        touch.shift = V::select(is_soft, soft.shift, zero);
        touch.on = V::select(is_soft, touch.on * soft.on, touch.on);
        keep = V::select(is_soft, soft.slide, zero);
        touch.slide = [start.dot(t1) * keep, start.dot(t2) * keep];
    }
    if g.params.spin_friction.is_some() {
        touch.twist = Twist::start(vel.ang, g.ball_omega, keep);
    }
    touch.rows.carry_to_base(w, path, body, point, &frame);
    touch.rows.solve_base(w);
    let across = (ball.radius * ball.radius).mul_add(ball.inv_inertia, ball.inv_mass);
    let [xx, yy, nn, xy, xn, yn] = touch.rows.couplings(w, path);
    touch.block = Block::new([xx + across, yy + across, nn + ball.inv_mass, xy, xn, yn]);
    let moved = robot + w.gyro;
    let mut free = [moved.dot(t1), moved.dot(t2), moved.dot(n)];
    touch.rows.free_joints(w, path, constants.dt, &mut free);
    touch.rows.free_base(w, &mut free);
    touch.free = free;
    true
}
}

/// One improvement of every contact between ball and robot; false if no impulse changed.
#[inline(always)]
pub(crate) fn sweep<V: Real>(layout: &ModelLayout<V::Scalar>, g: &Group<V>, w: &mut Work<V>) -> bool {
    let mut changed = false;
    let ball = &g.params.ball;
    let mut touches = core::mem::take(&mut w.touches);
    for slot in 0..touches.len() {
        let touch = &mut touches[slot];
        if !touch.active {
            continue;
        }
        let (path, _, _) = slot_path(layout, slot);
        let mut robot = touch.free;
        touch.rows.pushed_joints(w, path, &mut robot);
        touch.rows.pushed_base(w, &mut robot);
        let v = w.ball.surface_velocity(&touch.frame, ball.radius);
        let slide = touch.slide;
        let v = [v[0] - robot[0] - slide[0], v[1] - robot[1] - slide[1], v[2] - robot[2]];
        let (surface, impulse) = (&g.params.ball_robot, &mut touch.impulse);
        let friction = surface.friction();
        let change = match &g.params.cone {
            None => touch.block.solve(v, touch.target, touch.on, friction, impulse).change,
            Some(cone) => touch.block.solve_cone(v, touch.target, touch.on, friction, cone, impulse),
        };
        if let (Some(friction), Some(cone)) = (&g.params.spin_friction, &g.params.cone) {
            let normal = cone.left(touch.impulse, surface.dynamic_friction);
            let omega = &mut w.ball.omega;
            touch.twist.improve(touch.frame[2], friction, normal, ball.inv_inertia, omega);
        }
        if is_zero(&change) {
            continue;
        }
        changed = true;
        w.ball.push(&touch.frame, &change, ball.radius, ball.inv_mass, ball.inv_inertia);
        let back = [-change[0], -change[1], -change[2]];
        touch.rows.push_joints(w, path, &back);
        touch.rows.push_base(w, &back);
    }
    w.touches = touches;
    changed
}
