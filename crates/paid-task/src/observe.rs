//! Observations of a group.

use paid_lanes::rng::fill_symmetric;
use paid_lanes::{Mat3, Real, Vec3, store_f32};
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::lead;
use crate::score::projected_gravity;

/// Purpose of the noise stream among an environment's random numbers.
pub(crate) const NOISE_STREAM: u32 = 2;

/// A feature-major matrix seen from one lane group: each `push` writes the group's lanes of the next row.
pub(crate) struct Rows<'a> {
    out: &'a mut [f32],
    stride: usize,
    at: usize,
}

impl<'a> Rows<'a> {
    /// Rows of `[features, stride]`, beginning at environment `first`.
    #[inline(always)]
    pub(crate) fn new(out: &'a mut [f32], stride: usize, first: usize) -> Self {
        Self { out, stride, at: first }
    }
    #[inline(always)]
    fn push<V: Real>(&mut self, value: V) {
        store_f32(value, &mut self.out[self.at..self.at + V::LANES]);
        self.at += self.stride;
    }
    #[inline(always)]
    fn push_vec<V: Real>(&mut self, v: Vec3<V>) {
        for k in 0..3 {
            self.push(v.0[k]);
        }
    }
    /// The first two columns of a rotation, row by row.
    #[inline(always)]
    fn push_rotation<V: Real>(&mut self, m: &Mat3<V>) {
        for row in 0..3 {
            self.push(m.0[row][0]);
            self.push(m.0[row][1]);
        }
    }
}

/// Random numbers of one observation: uniform in (-1, 1), in the order of use.
struct Noise<'a, V> {
    values: &'a [V],
    next: usize,
}

/// Noisy numbers of an observation: gravity, two angular velocities, joint angles and velocities.
pub(crate) fn noise_len(joints: usize) -> usize {
    9 + 2 * joints
}

impl<V: Real> Noise<'_, V> {
    #[inline(always)]
    fn add(&mut self, value: V, half_width: f64) -> V {
        let noise = self.values[self.next];
        self.next += 1;
        noise.mul_add(V::c(half_width), value)
    }
    #[inline(always)]
    fn add_vec(&mut self, v: Vec3<V>, half_width: f64) -> Vec3<V> {
        let (x, y) = (self.add(v.x(), half_width), self.add(v.y(), half_width));
        Vec3([x, y, self.add(v.z(), half_width)])
    }
}

/// Ball and goal as the policy sees them, base frame [m].
#[derive(Clone, Copy)]
pub(crate) struct Seen<V> {
    pub ball: Vec3<V>,
    pub goal: Vec3<V>,
}

/// Whose noise, and which draw of it.
pub(crate) struct Draw<'a, V> {
    /// Environment numbers, a lane each; empty for no noise.
    pub envs: &'a [u32],
    pub seed: u64,
    pub count: u64,
    /// Room for [`noise_len`] numbers; zeros if there is no noise.
    pub values: &'a mut [V],
}

/// A world point in the base frame.
#[inline(always)]
pub(crate) fn in_base<V: Real>(state: &GroupState<V>, point: Vec3<V>) -> Vec3<V> {
    let base = &state.bodies[0];
    base.rot.tr_mul_vec(point - base.pos)
}

/// The ball where it will be when the reference strikes; where it is if the preset has no lead (then `lead_s` is 0).
#[inline(always)]
pub(crate) fn expected_ball<V: Real>(state: &GroupState<V>, group: &GroupTask<V>) -> Vec3<V> {
    state.ball.pos + lead::way(state.ball.vel, group.lead_s)
}

/// Writes the policy's observation.
#[inline(always)]
pub(crate) fn observe_policy<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &GroupTask<V>,
    seen: Seen<V>,
    draw: Draw<'_, V>,
    mut rows: Rows<'_>,
) {
    let joints = config.joints();
    let preset = &config.preset.observations.noise;
    if !draw.envs.is_empty() {
        fill_symmetric(draw.values, draw.envs, NOISE_STREAM, draw.seed, draw.count);
    }
    let mut noise = Noise { values: draw.values, next: 0 };
    let reference = &group.reference;
    for j in 0..joints {
        rows.push(reference.joint_pos(j));
    }
    for j in 0..joints {
        rows.push(reference.joint_vel(j));
    }
    let base = &state.bodies[0];
    let felt = |k: usize, now: V| group.late.as_ref().map_or(now, |late| late.felt(k, now));
    let felt_vec = |k: usize, v: Vec3<V>| Vec3([0, 1, 2].map(|i| felt(k + i, v.0[i])));
    rows.push_vec(noise.add_vec(felt_vec(0, projected_gravity(&base.rot)), preset.projected_gravity));
    rows.push_vec(noise.add_vec(reference.ang_vel(config.anchor), preset.reference_ang_vel));
    rows.push_vec(noise.add_vec(felt_vec(3, base.rot.tr_mul_vec(base.ang_vel)), preset.base_ang_vel));
    for j in 0..joints {
        rows.push(noise.add(felt(6 + j, joint_pos_rel(config, state, group, j)), preset.joint_pos));
    }
    for j in 0..joints {
        let now = state.joint_vel[config.to_model[j]];
        rows.push(noise.add(felt(6 + joints + j, now), preset.joint_vel));
    }
    for j in 0..joints {
        rows.push(group.action[j]);
    }
    rows.push_vec(seen.ball);
    rows.push_vec(seen.goal);
}

/// Writes the critic's observation, without noise.
#[inline(always)]
pub(crate) fn observe_critic<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &GroupTask<V>,
    mut rows: Rows<'_>,
) {
    let joints = config.joints();
    let reference = &group.reference;
    for j in 0..joints {
        rows.push(reference.joint_pos(j));
    }
    for j in 0..joints {
        rows.push(reference.joint_vel(j));
    }
    let anchor = &state.bodies[config.followed[config.anchor]];
    rows.push_vec(anchor.rot.tr_mul_vec(reference.pos(config.anchor) - anchor.pos));
    rows.push_rotation(&anchor.rot.tr_mul_mat(&reference.rot(config.anchor)));
    for i in 0..config.tracked {
        let body = &state.bodies[config.followed[i]];
        rows.push_vec(anchor.rot.tr_mul_vec(body.pos - anchor.pos));
    }
    for i in 0..config.tracked {
        let body = &state.bodies[config.followed[i]];
        rows.push_rotation(&anchor.rot.tr_mul_mat(&body.rot));
    }
    let base = &state.bodies[0];
    rows.push_vec(base.rot.tr_mul_vec(base.lin_vel));
    rows.push_vec(base.rot.tr_mul_vec(base.ang_vel));
    for j in 0..joints {
        rows.push(joint_pos_rel(config, state, group, j));
    }
    for j in 0..joints {
        rows.push(state.joint_vel[config.to_model[j]]);
    }
    for j in 0..joints {
        rows.push(group.action[j]);
    }
    rows.push_vec(in_base(state, expected_ball(state, group)));
    rows.push_vec(in_base(state, group.goal));
}

/// Angle of policy joint `j` relative to its default [rad].
#[inline(always)]
pub(crate) fn joint_pos_rel<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &GroupTask<V>,
    j: usize,
) -> V {
    let m = config.to_model[j];
    state.joint_pos[m] - (group.joint_offset[m] + V::c(config.control.default_pos[m]))
}
