//! The ball: a free sphere that meets the ground at velocity level.

use paid_lanes::{Mask, Real, Vec3};

use super::block::{Block, ground_tangents};
use super::group::{Group, Work};
use super::layout::ModelLayout;
use super::rows::is_body;
use super::solver::SOLVER;
use super::step::Constants;
use super::touch::slot_path;
use super::twist::Twist;

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
    /// Sliding velocity that a soft contact leaves.
    slide: [V; 2],
    /// 0 in soft lanes that do not touch, else 1.
    on: V,
    twist: Twist<V>,
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
            slide: [z; 2],
            on: z,
            twist: Twist::zero(),
        }
    }

    /// Velocity of the ball's surface opposite to `n`, in the frame.
    #[inline(always)]
    pub fn surface_velocity(&self, frame: &[Vec3<V>; 3], radius: V) -> [V; 3] {
        let lever = frame[2].scale(-radius);
        let v = self.omega.cross_add(lever, self.vel);
        [v.dot(frame[0]), v.dot(frame[1]), v.dot(frame[2])]
    }

    /// Applies an impulse in the frame at the surface opposite to `n`.
    #[inline(always)]
    pub fn push(&mut self, frame: &[Vec3<V>; 3], impulse: &[V; 3], radius: V, inv_mass: V, inv_inertia: V) {
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

    let spring = &params.ball_ground_spring;
    let one = V::one();
    ball.slide = [zero; 2];
    ball.on = one;
    let mut keep = zero;
    if spring.any {
        let soft = spring.target(gap, speed, h, SOLVER.ball_soft_reach_m);
        let is_soft = spring.is_soft();
        ball.target = V::select(is_soft, soft.speed, ball.target);
        ball.shift = V::select(is_soft, soft.shift, ball.shift);
        ball.on = V::select(is_soft, soft.on, one);
        keep = V::select(is_soft, soft.slide, zero);
        let start = g.ball_omega.cross_add(n.scale(-radius), g.ball_vel);
        ball.slide = [start.dot(t1) * keep, start.dot(t2) * keep];
    }
    if params.spin_friction.is_some() {
        ball.twist = Twist::start(Vec3::zero(), g.ball_omega, keep);
    }
}

/// One improvement of the ground contact.
#[inline(always)]
pub(crate) fn sweep_ground<V: Real>(g: &Group<V>, w: &mut Work<V>) {
    let params = &g.params;
    let ball = &mut w.ball;
    let frame = ball.frame;
    let v = ball.surface_velocity(&frame, params.ball.radius);
    let v = [v[0] - ball.slide[0], v[1] - ball.slide[1], v[2]];
    let (friction, impulse) = (params.ball_ground.friction(), &mut ball.impulse);
    let change = match &params.cone {
        None => ball.block.solve(v, ball.target, ball.on, friction, impulse).change,
        Some(cone) => ball.block.solve_cone(v, ball.target, ball.on, friction, cone, impulse),
    };
    ball.push(&frame, &change, params.ball.radius, params.ball.inv_mass, params.ball.inv_inertia);
    if let (Some(friction), Some(cone)) = (&params.spin_friction, &params.cone) {
        let normal = cone.left(ball.impulse, params.ball_ground.dynamic_friction);
        ball.twist.improve(frame[2], friction, normal, params.ball.inv_inertia, &mut ball.omega);
    }
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
        if g.params.ball_robot_spring.any {
            let pushed = V::select(V::zero().lt(touch.impulse[2]), touch.shift, V::zero());
            g.ball_pos = touch.frame[2].scale_add(pushed, g.ball_pos);
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
