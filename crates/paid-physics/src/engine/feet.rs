//! Soles on the ground, at velocity level: the inverse operational-space inertia of the two feet and the sweeps on it.

use paid_lanes::{Mask, Mat3, Real, Vec3};

use super::block::{Block, Friction, ground_tangents};
use super::group::{Group, JointWork, Work};
use super::phase::phase;
use super::plan::Plan;
use super::spatial::{BaseFactor, Force, Motion, splat3};
use super::step::Constants;

/// Points farther from the ground than this are left out [m]. A foot at 4 m/s travels as far in a 5 ms step.
const REACH: f64 = 0.02;
/// Overlap that is not corrected: keeps resting contacts closed [m].
const SLOP: f64 = 0.001;
/// Fastest correction of an overlap [m/s].
const MAX_PUSH: f64 = 0.5;

/// Index of element (r, c) in a packed lower triangle.
#[inline(always)]
fn packed(r: usize, c: usize) -> usize {
    if r >= c { r * (r + 1) / 2 + c } else { c * (c + 1) / 2 + r }
}

/// A foot's response to impulses.
#[derive(Clone, Debug)]
pub(crate) struct Foot<V> {
    /// Half-solved unit impulses: joint (base to tip) by wrench component.
    pub joints: Vec<[V; 6]>,
    /// The same at the base: row by wrench component.
    pub base: [[V; 6]; 6],
    /// Velocity per impulse, packed lower triangle.
    pub inverse: [V; 21],
    /// Velocity under way to the end of the step.
    pub vel: Motion<V>,
    /// Sum of the contact impulses.
    pub impulse: Force<V>,
    /// Coefficient of friction of the sole under way: static or dynamic.
    friction: V,
}

impl<V: Real> Foot<V> {
    pub fn new(joints: usize) -> Self {
        let z = V::zero();
        Self {
            joints: vec![[z; 6]; joints],
            base: [[z; 6]; 6],
            inverse: [z; 21],
            vel: Motion::zero(),
            impulse: Force::zero(),
            friction: z,
        }
    }

    /// Half-solves three of the six unit impulses (moments for `first` 0, forces for 3); three at a time stay in registers.
    #[inline(always)]
    fn half_solve(&mut self, first: usize, work: &[JointWork<V>], factor: &BaseFactor<V>) {
        let mut p = [[V::zero(); 3]; 6];
        for c in 0..3 {
            p[first + c][c] = V::one();
        }
        for i in (0..work.len()).rev() {
            let axis = work[i].axis.array();
            let gain = &work[i].gain;
            let mut y = [V::zero(); 3];
            for c in 0..3 {
                let mut sum = axis[0] * p[0][c];
                for r in 1..6 {
                    sum = axis[r].mul_add(p[r][c], sum);
                }
                y[c] = sum;
                self.joints[i][first + c] = sum;
            }
            for r in 0..6 {
                for c in 0..3 {
                    p[r][c] = gain[r].neg_mul_add(y[c], p[r][c]);
                }
            }
        }
        for c in 0..3 {
            let mut column = [p[0][c], p[1][c], p[2][c], p[3][c], p[4][c], p[5][c]];
            factor.half_solve(&mut column);
            for r in 0..6 {
                self.base[r][first + c] = column[r];
            }
        }
    }

    /// Velocity per impulse from the half-solved columns.
    #[inline(always)]
    fn build_inverse(&mut self, work: &[JointWork<V>], factor: &BaseFactor<V>) {
        let mut sum = [V::zero(); 21];
        for i in 0..work.len() + 6 {
            let (y, d) = if i < work.len() {
                (&self.joints[i], work[i].inv)
            } else {
                (&self.base[i - work.len()], factor.inv[i - work.len()])
            };
            let mut n = 0;
            for r in 0..6 {
                let scaled = y[r] * d;
                for c in 0..=r {
                    sum[n] = scaled.mul_add(y[c], sum[n]);
                    n += 1;
                }
            }
        }
        self.inverse = sum;
    }

    /// Velocity at the end of the step without contacts.
    #[inline(always)]
    fn free_velocity(&mut self, now: Motion<V>, gyro: Vec3<V>, work: &[JointWork<V>], w: &FreeBase<V>) {
        let mut v = Motion { ang: now.ang, lin: now.lin + gyro }.array();
        for i in 0..work.len() {
            let x = work[i].torque * work[i].inv * w.dt;
            for c in 0..6 {
                v[c] = self.joints[i][c].mul_add(x, v[c]);
            }
        }
        for i in 0..6 {
            for c in 0..6 {
                v[c] = self.base[i][c].mul_add(w.scaled[i], v[c]);
            }
        }
        self.vel = Motion::from_array(v);
    }

    /// The foot's velocity changed by an impulse on it.
    #[inline(always)]
    fn push(&mut self, f: [V; 6]) {
        let mut v = self.vel.array();
        for r in 0..6 {
            for c in 0..6 {
                v[r] = self.inverse[packed(r, c)].mul_add(f[c], v[r]);
            }
        }
        self.vel = Motion::from_array(v);
    }
}

/// The base's half-solved free impulse, scaled.
#[derive(Clone, Copy, Debug)]
struct FreeBase<V> {
    scaled: [V; 6],
    dt: V,
}

/// One sole point. Vectors in the contact frame are (t1, t2, n).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sole<V> {
    /// Contact point relative to the base's origin.
    pub point: Vec3<V>,
    /// Contact frame: columns t1, t2, n in world axes. Not read on the plane.
    frame: Mat3<V>,
    /// Foot velocity per impulse at the point: component by frame axis.
    response: [[V; 3]; 6],
    block: Block<V>,
    target: V,
    on: V,
    pub impulse: [V; 3],
}

impl<V: Real> Sole<V> {
    pub fn new() -> Self {
        let z = V::zero();
        Self {
            point: Vec3::zero(),
            frame: Mat3::identity(),
            response: [[z; 3]; 6],
            block: Block::zero(),
            target: z,
            on: z,
            impulse: [z; 3],
        }
    }

    /// Builds the response at `point` from the foot's inverse inertia.
    #[inline(always)]
    fn build_response<const PLANE: bool>(&mut self, inverse: &[V; 21]) {
        let p = self.point.0;
        for r in 0..6 {
            let moment = Vec3([inverse[packed(r, 0)], inverse[packed(r, 1)], inverse[packed(r, 2)]]);
            let force = Vec3([inverse[packed(r, 3)], inverse[packed(r, 4)], inverse[packed(r, 5)]]);
            // Row times (p x d, d) for the world axes d.
            let row = moment.cross_add(Vec3(p), force);
            self.response[r] = if PLANE { row.0 } else { self.frame.tr_mul_vec(row).0 };
        }
        let mut k = [[V::zero(); 3]; 3];
        for c in 0..3 {
            let g = &self.response;
            let column = Motion::from_array([g[0][c], g[1][c], g[2][c], g[3][c], g[4][c], g[5][c]]);
            k[c] = self.in_frame::<PLANE>(column.at(self.point));
        }
        self.block = Block::new([k[0][0], k[1][1], k[2][2], k[1][0], k[2][0], k[2][1]]);
    }

    #[inline(always)]
    fn in_frame<const PLANE: bool>(&self, v: Vec3<V>) -> [V; 3] {
        if PLANE { v.0 } else { self.frame.tr_mul_vec(v).0 }
    }

    /// The impulse in world axes.
    #[inline(always)]
    pub fn world_impulse<const PLANE: bool>(&self) -> Vec3<V> {
        if PLANE { Vec3(self.impulse) } else { self.frame.mul_vec(Vec3(self.impulse)) }
    }
}

phase! {
/// How the feet answer to impulses, and their velocities without contacts.
pub(crate) fn respond<'a, V>(
    plan: &'a Plan<V::Scalar>,
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
        let chain = plan.chains[plan.legs[f]];
        let joints = &w.joints[chain.first..chain.end];
        let foot = &mut w.feet[f];
        foot.half_solve(0, joints, &w.factor);
        foot.half_solve(3, joints, &w.factor);
        foot.build_inverse(joints, &w.factor);
        foot.free_velocity(w.kin[plan.legs[f]].vel, w.gyro, joints, &free);
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
    plan: &'a Plan<V::Scalar>,
    constants: &'a Constants<'a, V>,
    g: &'a Group<V>,
    w: &'a mut Work<V>,
) -> () {
    let zero = V::zero();
    let restitution = g.params.robot_ground.restitution;
    let bouncy = zero.lt(restitution).any();
    for f in 0..2 {
        let kin = w.kin[plan.legs[f]];
        for i in 0..plan.soles.len() {
            let (center, radius) = &plan.soles[i][f];
            let radius = V::splat(*radius);
            let center = kin.place(splat3(center));
            let sole = &mut w.soles[i][f];
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
            sole.build_response::<PLANE>(&w.feet[f].inverse);
            let speed = if bouncy { sole.in_frame::<PLANE>(kin.vel.at(sole.point))[2] } else { zero };
            sole.target = constants.approach.target(gap, SLOP, speed, restitution, MAX_PUSH);
            let on = V::select(gap.lt(V::c(REACH)), V::one(), zero);
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
    let mut vel = [w.feet[0].vel.array(), w.feet[1].vel.array()];
    let mut wanted = [[V::zero(); 3]; 2];
    for i in 0..w.soles.len() {
        for f in 0..2 {
            let sole = &mut w.soles[i][f];
            let v = sole.in_frame::<PLANE>(Motion::from_array(vel[f]).at(sole.point));
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
    plan: &Plan<V::Scalar>,
    constants: &Constants<V>,
    g: &mut Group<V>,
    w: &mut Work<V>,
) {
    for f in 0..2 {
        let chain = plan.chains[plan.legs[f]];
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
        w.force[chain.end] += w.feet[f].impulse.lin.scale(constants.inv_dt);
    }
}

#[inline(always)]
pub(crate) fn dot6<V: Real>(a: &[V; 6], b: &[V; 6]) -> V {
    let x = a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]));
    let y = a[5].mul_add(b[5], a[4].mul_add(b[4], a[3] * b[3]));
    x + y
}
