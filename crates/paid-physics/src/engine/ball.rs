//! The ball: a free sphere that meets the ground and the robot at velocity level.

use paid_lanes::{Mask, Real, Vec3};

use super::block::{Block, ground_tangents, tangents};
use super::group::{Group, Work};
use super::layout::ModelLayout;
use super::phase::phase;
use super::rows::{Rows, is_body};
use super::solver::SOLVER;
use super::spatial::{Motion, length, unit};
use super::step::Constants;

/// The ball's velocity, on its way to the end of the step, and its ground contact.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BallWork<V> {
    pub vel: Vec3<V>,
    pub omega: Vec3<V>,
    /// Contact frame with the ground: two tangents, normal.
    frame: [Vec3<V>; 3],
    block: Block<V>,
    target: V,
    impulse: [V; 3],
    /// Where a bounce within the step leaves the ball, beyond the straight integration, along the normal `[m]`.
    shift: V,
}

impl<V: Real> BallWork<V> {
    pub fn new() -> Self {
        let z = V::zero();
        Self {
            vel: Vec3::zero(),
            omega: Vec3::zero(),
            frame: [Vec3::zero(); 3],
            block: Block::zero(),
            target: z,
            impulse: [z; 3],
            shift: z,
        }
    }

    /// Velocity of the ball's surface opposite to `n`, in the frame.
    #[inline(always)]
    fn surface_velocity(&self, frame: &[Vec3<V>; 3], radius: V) -> [V; 3] {
        let lever = frame[2].scale(-radius);
        let v = self.omega.cross_add(lever, self.vel);
        [v.dot(frame[0]), v.dot(frame[1]), v.dot(frame[2])]
    }

    /// Applies an impulse in the frame at the surface opposite to `n`.
    #[inline(always)]
    fn push(&mut self, frame: &[Vec3<V>; 3], impulse: &[V; 3], radius: V, inv_mass: V, inv_inertia: V) {
        let p = in_world(frame, impulse);
        self.vel = p.scale_add(inv_mass, self.vel);
        self.omega = frame[2].scale(-radius).cross(p).scale_add(inv_inertia, self.omega);
    }
}

#[inline(always)]
fn in_world<V: Real>(frame: &[Vec3<V>; 3], x: &[V; 3]) -> Vec3<V> {
    frame[2].scale_add(x[2], frame[1].scale_add(x[1], frame[0].scale(x[0])))
}

/// Free flight over the step, and the contact with the ground.
#[inline(always)]
pub(crate) fn prepare_ground<V: Real>(constants: &Constants<V>, g: &Group<V>, w: &mut Work<V>) {
    let zero = V::zero();
    let h = constants.dt;
    let params = &g.params;
    let ball = &mut w.ball;
    let keep = params.ball.linear_keep;
    let [vx, vy, vz] = g.ball_vel.0;
    ball.vel = Vec3([vx * keep, vy * keep, constants.gravity.mul_add(h, vz) * keep]);
    ball.omega = g.ball_omega.scale(params.ball.angular_keep);
    let (height, n) = constants.ground.at(g.ball_pos.0[0], g.ball_pos.0[1], params);
    let [t1, t2] = ground_tangents(n);
    ball.frame = [t1, t2, n];
    let radius = params.ball.radius;
    let gap = (g.ball_pos.0[2] - height).mul_add(n.0[2], -radius);
    let across = (radius * radius).mul_add(params.ball.inv_inertia, params.ball.inv_mass);
    ball.block = Block::new([across, across, params.ball.inv_mass, zero, zero, zero]);
    ball.impulse = [zero; 3];

    // Semi-implicit Euler keeps velocities half a step behind: the speed at the instant of impact, a time `until`
    // into the step, is that of free fall half a step longer. A bounce then continues for the rest of the step.
    let speed = g.ball_vel.dot(n);
    let pull = -(constants.gravity * n.0[2]);
    let half = V::c(0.5) * h;
    let free = pull.neg_mul_add(h, speed);
    let hits = free.mul_add(h, gap).lt(zero);
    let until = (gap * (-speed).max(V::c(1e-6)).recip()).max(zero).min(h);
    let impact = pull.mul_add(half + until, -speed);
    let rebound = params.ball_ground.restitution * impact;
    let bounce = (half - until).neg_mul_add(pull, rebound);
    let bounces = hits.and(constants.approach.bounce_threshold.lt(impact)).and(zero.lt(bounce));
    let rest = h - until;
    let after = (V::c(0.5) * pull * rest).neg_mul_add(rest, rebound * rest);
    let position = constants.approach.target(gap, SOLVER.ball_slop_m, zero, zero, SOLVER.ball_max_push);
    ball.target = V::select(bounces, bounce, position);
    ball.shift = V::select(bounces, after - bounce.mul_add(h, gap), zero);
}

/// One improvement of the ground contact.
#[inline(always)]
pub(crate) fn sweep_ground<V: Real>(g: &Group<V>, w: &mut Work<V>) {
    let params = &g.params;
    let ball = &mut w.ball;
    let frame = ball.frame;
    let v = ball.surface_velocity(&frame, params.ball.radius);
    let change =
        ball.block.solve(v, ball.target, V::one(), params.ball_ground.friction(), &mut ball.impulse).change;
    ball.push(&frame, &change, params.ball.radius, params.ball.inv_mass, params.ball.inv_inertia);
}

/// Contact of the ball with the nearest shape of a chain.
#[derive(Clone, Debug)]
pub(crate) struct BallTouch<V: Real> {
    rows: Rows<V, 3>,
    /// Some lane is in contact.
    pub active: bool,
    /// The touched body of each lane.
    body: V,
    frame: [Vec3<V>; 3],
    block: Block<V>,
    target: V,
    on: V,
    /// Velocity of the robot's surface without contacts, in the frame.
    free: [V; 3],
    /// On the ball, in the frame.
    impulse: [V; 3],
}

impl<V: Real> BallTouch<V> {
    pub fn new(joints: usize) -> Self {
        let z = V::zero();
        Self {
            rows: Rows::new(joints),
            active: false,
            body: z,
            frame: [Vec3::zero(); 3],
            block: Block::zero(),
            target: z,
            on: z,
            free: [z; 3],
            impulse: [z; 3],
        }
    }
}

/// The path of touch slot `slot` (0 is the base), its shapes, and its bodies.
#[inline(always)]
fn slot_path<S: paid_lanes::Scalar>(
    layout: &ModelLayout<S>,
    slot: usize,
) -> (&[usize], [usize; 2], [usize; 2]) {
    if slot == 0 {
        return (&[], layout.base_capsules, [0, 1]);
    }
    let chain = layout.chains[slot - 1];
    let shapes = [layout.links[chain.first].capsules[0], layout.links[chain.end - 1].capsules[1]];
    (&layout.paths[slot - 1], shapes, [chain.first + 1, chain.end + 1])
}

/// Finds and prepares the contacts between ball and robot; true if there is one.
#[inline(always)]
pub(crate) fn prepare_robot<V: Real>(
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
    for slot in 0..touches.len() {
        let touch = &mut touches[slot];
        touch.active = near && prepare_touch(layout, constants, g, w, slot, center, touch);
        found |= touch.active;
    }
    w.touches = touches;
    found
}

phase! {
/// Finds and prepares the contact of one slot; false if no lane touches.
fn prepare_touch<'a, V>(
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
    let mut gap = V::c(1e3);
    let mut axis_point = Vec3::zero();
    let mut shape_radius = zero;
    let mut body = V::c(bodies[0] as f64);
    for i in shapes[0]..shapes[1] {
        let capsule = &layout.capsules[i];
        let [a, b] = w.ends[i];
        let along = b - a;
        let t = ((center - a).dot(along) * V::splat(capsule.inv_length2)).clamp(zero, V::one());
        let nearest = along.scale_add(t, a);
        let d = center - nearest;
        let this = length(d) - (V::splat(capsule.radius) + ball.radius);
        let closer = this.lt(gap);
        gap = V::select(closer, this, gap);
        axis_point = Vec3::select(closer, nearest, axis_point);
        shape_radius = V::select(closer, V::splat(capsule.radius), shape_radius);
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
    let n = unit(d);
    let point = n.scale_add(shape_radius, axis_point);
    let robot = vel.at(point);
    let lever = n.scale(-ball.radius);
    let speed = (g.ball_omega.cross_add(lever, g.ball_vel) - robot).dot(n);
    let on = speed.min(zero).mul_add(constants.dt, gap).lt(V::c(SOLVER.ball_margin_m)).and(near);
    if !on.any() {
        return false;
    }
    let [t1, t2] = tangents(n);
    let frame = [t1, t2, n];
    touch.body = body;
    touch.frame = frame;
    touch.on = V::select(on, V::one(), zero);
    touch.impulse = [zero; 3];
    touch.target = constants.approach.target(gap, SOLVER.ball_slop_m, speed, g.params.ball_robot.restitution, SOLVER.ball_max_push);
    touch.rows.carry_to_base(w, path, body, point, &frame);
    touch.rows.solve_base(w);
    let rows = &touch.rows;
    let across = (ball.radius * ball.radius).mul_add(ball.inv_inertia, ball.inv_mass);
    touch.block = Block::new([
        rows.coupling(w, path, 0, 0) + across,
        rows.coupling(w, path, 1, 1) + across,
        rows.coupling(w, path, 2, 2) + ball.inv_mass,
        rows.coupling(w, path, 0, 1),
        rows.coupling(w, path, 0, 2),
        rows.coupling(w, path, 1, 2),
    ]);
    let moved = robot + w.gyro;
    let mut free = [moved.dot(t1), moved.dot(t2), moved.dot(n)];
    touch.rows.free_joints(w, path, constants.dt, &mut free);
    touch.rows.free_base(w, &mut free);
    touch.free = free;
    true
}
}

/// One improvement of every contact between ball and robot.
#[inline(always)]
pub(crate) fn sweep_robot<V: Real>(layout: &ModelLayout<V::Scalar>, g: &Group<V>, w: &mut Work<V>) {
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
        let v = [v[0] - robot[0], v[1] - robot[1], v[2] - robot[2]];
        let change = touch
            .block
            .solve(v, touch.target, touch.on, g.params.ball_robot.friction(), &mut touch.impulse)
            .change;
        w.ball.push(&touch.frame, &change, ball.radius, ball.inv_mass, ball.inv_inertia);
        let back = [-change[0], -change[1], -change[2]];
        touch.rows.push_joints(w, path, &back);
        touch.rows.push_base(w, &back);
    }
    w.touches = touches;
}

/// Moves the ball to the end of the step and reports its contact forces.
#[inline(always)]
pub(crate) fn finish<V: Real>(
    layout: &ModelLayout<V::Scalar>,
    constants: &Constants<V>,
    g: &mut Group<V>,
    w: &mut Work<V>,
) {
    let ball = w.ball;
    g.ball_vel = ball.vel;
    g.ball_omega = ball.omega;
    g.ball_pos = ball.vel.scale_add(constants.dt, g.ball_pos);
    let bounced = V::select(V::zero().lt(ball.impulse[2]), ball.shift, V::zero());
    g.ball_pos = ball.frame[2].scale_add(bounced, g.ball_pos);
    let report = &mut g.state.ball;
    let ground = in_world(&ball.frame, &ball.impulse).scale(constants.inv_dt);
    report.ground_force =
        Vec3::select(ground.norm2().gt(report.ground_force.norm2()), ground, report.ground_force);
    for slot in 0..w.touches.len() {
        let touch = &w.touches[slot];
        if !touch.active {
            continue;
        }
        let force = in_world(&touch.frame, &touch.impulse).scale(constants.inv_dt);
        let stronger = force.norm2().gt(report.robot_force.norm2());
        report.robot_force = Vec3::select(stronger, force, report.robot_force);
        report.touched_by = V::select(stronger, touch.body, report.touched_by);
        let on_robot = force.scale(-V::one());
        let (_, _, bodies) = slot_path(layout, slot);
        for b in bodies[0]..bodies[1] {
            w.forces.add(b, on_robot, is_body(touch.body, b));
        }
    }
}
