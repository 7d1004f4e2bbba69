//! Reward and failure of a group after a control step.

use paid_lanes::{Mask, Real, Vec3};
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::kick::is_set;
use crate::terms::regularization::{foot_separation, outside, squared_change, tilt, touches};
use crate::terms::soccer::{alignment, planar_speed, proximity, side_kick, speed_share, vertical_speed};
use crate::terms::tracking::{
    KernelMean, aligned_position, around_strike, gaussian, orientation_error, yaw_alignment,
};
use crate::{ProximityPoint, REWARD_TERMS, TRACKING_NAMES};

/// Sums over steps and groups, a lane each.
#[derive(Clone, Debug)]
pub(crate) struct Sums<V> {
    pub terms: [V; REWARD_TERMS],
    pub tracking: [V; TRACKING_NAMES.len()],
}

impl<V: Real> Sums<V> {
    pub(crate) fn new() -> Self {
        Self { terms: [V::zero(); REWARD_TERMS], tracking: [V::zero(); TRACKING_NAMES.len()] }
    }
}

/// Result of a control step; masks have one bit a lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Score<V> {
    /// Reward: the sum of term x weight x control period; 0 in lanes that are not finite.
    pub reward: V,
    /// Failures, in the order of [`crate::EndCause`]: anchor height, gravity, end effector, anchor distance,
    /// not finite.
    pub failed: [u32; 5],
    /// First contact between robot and ball.
    pub first_contact: u32,
    /// It was by the labeled foot.
    pub correct: u32,
    /// The right foot is nearer to the ball.
    pub right: u32,
}

/// Gravity's direction in a frame with rotation `rot`.
#[inline(always)]
pub(crate) fn projected_gravity<V: Real>(rot: &paid_lanes::Mat3<V>) -> Vec3<V> {
    Vec3([-rot.0[2][0], -rot.0[2][1], -rot.0[2][2]])
}

/// Scores the state against the group's reference and advances the ball's story.
#[inline(always)]
pub(crate) fn score<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &mut GroupTask<V>,
    sums: &mut Sums<V>,
) -> Score<V> {
    let preset = &config.preset.rewards;
    let mut terms = [V::zero(); REWARD_TERMS];
    let mut errors = [V::zero(); TRACKING_NAMES.len()];
    tracking_terms(config, state, group, &mut terms, &mut errors);
    clean_terms(config, state, group, &mut terms);
    let (mut first_contact, mut correct, mut right) = (0, 0, 0);
    if config.preset.scene.ball {
        let ball = &state.ball;
        let feet = [foot(config, state, 0), foot(config, state, 1)];
        let step = group.kick.advance(ball, [feet[0].pos, feet[1].pos], &preset.kick);
        let point = match preset.ball_prox.from {
            ProximityPoint::Anchor => state.bodies[config.followed[config.anchor]].pos,
            ProximityPoint::Base => state.bodies[0].pos,
        };
        let near = proximity(point, ball.pos, preset.ball_prox.sigma);
        let kick = &mut group.kick;
        kick.frozen = V::select(step.first, near, kick.frozen);
        terms[7] = V::select(is_set(kick.touched), kick.frozen, near);
        terms[8] = V::select(step.correct, V::one(), V::zero());
        let left_swing = side_kick(feet[0].rot.tr_mul_vec(feet[0].com_vel), V::c(-1.0));
        let right_swing = side_kick(feet[1].rot.tr_mul_vec(feet[1].com_vel), V::c(1.0));
        let swing = V::select(step.right, right_swing, left_swing);
        terms[9] = V::select(step.correct, swing, V::zero());
        let (vx, vy) = (ball.vel.x(), ball.vel.y());
        let limit = preset.kick.min_ball_speed;
        let pays = step.window.and(vx.mul_add(vx, vy * vy).ge(V::c(limit * limit)));
        let aligned = alignment(ball.vel, kick.before, group.goal, preset.vel_align.sigma);
        let speed = vx.mul_add(vx, vy * vy).sqrt();
        let share = speed_share(speed, preset.kick.full_ball_speed);
        terms[10] = V::select(pays, aligned * share, V::zero());
        terms[11] = V::select(pays, planar_speed(ball.vel, preset.speed.sigma), V::zero());
        let vertical = vertical_speed(ball.vel, preset.z_speed.sigma);
        terms[12] = V::select(step.z_window, vertical, V::zero());
        let half_width = 0.5 * config.preset.goal.width_m;
        kick.observe_outcome(ball, group.goal, group.heading, preset.kick.window_steps, half_width);
        (first_contact, correct, right) = (step.first.bits(), step.correct.bits(), step.right.bits());
    }
    let mut total = V::zero();
    let weights = preset.weights();
    for k in 0..REWARD_TERMS {
        terms[k] *= V::c(weights[k] * config.dt_s);
        total += terms[k];
    }
    if let Some(kept) = &mut group.terms {
        **kept = terms;
    }
    let finite = finite(state).and(total.is_finite());
    for k in 0..REWARD_TERMS {
        sums.terms[k] += V::select(finite, terms[k], V::zero());
    }
    for k in 0..errors.len() {
        sums.tracking[k] += V::select(finite, errors[k], V::zero());
    }
    let reward = V::select(finite, total, V::zero());
    group.episode_return += reward;
    let [anchor, gravity, ends, distance] = failures(config, state, group).map(|mask| mask.bits());
    let failed = [anchor, gravity, ends, distance, finite.not().bits()];
    Score { reward, failed, first_contact, correct, right }
}

#[inline(always)]
fn foot<'a, V: Real>(
    config: &TaskConfig,
    state: &'a GroupState<V>,
    side: usize,
) -> &'a paid_physics::BodyState<V> {
    &state.bodies[config.followed[config.feet[side]]]
}

/// Terms 0 to 6 and 19 to 22, and the logged errors.
#[inline(always)]
fn tracking_terms<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &mut GroupTask<V>,
    terms: &mut [V; REWARD_TERMS],
    errors: &mut [V; TRACKING_NAMES.len()],
) {
    let preset = &config.preset.rewards;
    let reference = &group.reference;
    let anchor = &state.bodies[config.followed[config.anchor]];
    let (target_pos, target_rot) = (reference.pos(config.anchor), reference.rot(config.anchor));
    let turn = yaw_alignment(&anchor.rot, &target_rot);
    let anchor_error2 = (anchor.pos - target_pos).norm2();
    let anchor_angle = orientation_error(&anchor.rot, &target_rot);
    terms[0] = gaussian(anchor_error2, preset.anchor_pos.sigma);
    terms[1] = gaussian(anchor_angle * anchor_angle, preset.anchor_ori.sigma);

    let mut pos = KernelMean::new(preset.body_kernel, preset.body_pos.sigma);
    let mut ori = KernelMean::new(preset.body_kernel, preset.body_ori.sigma);
    let mut lin = KernelMean::new(preset.body_kernel, preset.lin_vel.sigma);
    let mut ang = KernelMean::new(preset.body_kernel, preset.ang_vel.sigma);
    let mut error_sums = [V::zero(); 4];
    for i in 0..config.tracked {
        let body = &state.bodies[config.followed[i]];
        let target = aligned_position(&turn, anchor.pos, target_pos, reference.pos(i));
        let pos2 = (body.pos - target).norm2();
        let angle = orientation_error(&body.rot, &turn.mul_mat(&reference.rot(i)));
        let lin2 = (body.com_vel - reference.com_vel(i)).norm2();
        let ang2 = (body.ang_vel - reference.ang_vel(i)).norm2();
        if !(preset.body_pos.exclude_feet && config.feet.contains(&i)) {
            pos.add(pos2);
        }
        ori.add(angle * angle);
        lin.add(lin2);
        ang.add(ang2);
        error_sums[0] += pos2.sqrt();
        error_sums[1] += angle;
        error_sums[2] += lin2.sqrt();
        error_sums[3] += ang2.sqrt();
    }
    terms[2] = pos.value();
    terms[3] = ori.value();
    terms[4] = lin.value();
    terms[5] = ang.value();

    let mut foot_pos = KernelMean::new(preset.body_kernel, preset.foot_pos.sigma);
    let mut feet_vel = KernelMean::new(preset.body_kernel, preset.feet_vel.sigma);
    let mut pos2 = [V::zero(); 2];
    let mut vel2 = [V::zero(); 2];
    for side in 0..2 {
        let i = config.feet[side];
        let body = foot(config, state, side);
        let target = aligned_position(&turn, anchor.pos, target_pos, reference.pos(i));
        pos2[side] = (body.pos - target).norm2();
        vel2[side] = (body.com_vel - reference.com_vel(i)).norm2();
        foot_pos.add(pos2[side]);
        feet_vel.add(vel2[side]);
    }
    terms[6] = foot_pos.value();
    terms[20] = feet_vel.value();
    let mut hand_pos = KernelMean::new(preset.body_kernel, preset.hand_pos.sigma);
    for &i in config.end_effectors.iter().filter(|i| !config.feet.contains(i)) {
        let target = aligned_position(&turn, anchor.pos, target_pos, reference.pos(i));
        hand_pos.add((state.bodies[config.followed[i]].pos - target).norm2());
    }
    terms[22] = hand_pos.value();
    let is_right = group.kick.label.gt(V::zero());
    terms[19] =
        around_strike(V::select(is_right, vel2[1], vel2[0]), group.to_strike_s, &preset.kick_foot_vel);
    terms[21] =
        around_strike(V::select(is_right, pos2[1], pos2[0]), group.to_strike_s, &preset.kick_foot_pos);
    let kicking = Vec3::select(is_right, foot(config, state, 1).com_vel, foot(config, state, 0).com_vel);
    let wanted = Vec3::select(is_right, reference.com_vel(config.feet[1]), reference.com_vel(config.feet[0]));
    group.foot_peak = kicking.norm().max(group.foot_peak);
    group.reference_peak = wanted.norm().max(group.reference_peak);

    let share = V::c(1.0 / config.tracked as f64);
    errors[0] = anchor_error2.sqrt();
    errors[1] = anchor_angle;
    for k in 0..4 {
        errors[2 + k] = error_sums[k] * share;
    }
    let (mut joint2, mut speed2) = (V::zero(), V::zero());
    for j in 0..config.joints() {
        let m = config.to_model[j];
        let d = state.joint_pos[m] - reference.joint_pos(j);
        let v = state.joint_vel[m] - reference.joint_vel(j);
        joint2 = d.mul_add(d, joint2);
        speed2 = v.mul_add(v, speed2);
    }
    errors[6] = joint2.sqrt();
    errors[7] = speed2.sqrt();
}

/// Terms 13 to 18.
#[inline(always)]
fn clean_terms<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &GroupTask<V>,
    terms: &mut [V; REWARD_TERMS],
) {
    let preset = &config.preset.rewards;
    let (mut rate, mut waist, mut limit, mut contacts) = (V::zero(), V::zero(), V::zero(), V::zero());
    for j in 0..config.joints() {
        rate += squared_change(group.action[j], group.previous[j]);
    }
    for &j in &config.waist {
        waist += squared_change(group.action[j], group.previous[j]);
    }
    for j in 0..config.joints() {
        let [lo, hi] = config.control.soft_range[j];
        limit += outside(state.joint_pos[j], lo, hi);
    }
    for &b in &config.undesired {
        contacts += touches(state.contact_force[b].norm(), preset.undesired_contact.force_n);
    }
    terms[13] = rate.min(V::c(preset.action_rate.clip));
    terms[14] = limit;
    terms[15] = contacts;
    let (left, right) = (foot(config, state, 0).pos, foot(config, state, 1).pos);
    terms[16] = foot_separation(left, right, preset.foot_sep.distance_m, preset.foot_sep.sigma);
    terms[17] = waist.min(V::c(preset.waist_rate.clip));
    terms[18] = tilt(projected_gravity(&state.bodies[0].rot));
}

/// Failed tracking: anchor height, gravity, end effectors, anchor distance. A limit of 0 or less never fails.
#[inline(always)]
fn failures<V: Real>(config: &TaskConfig, state: &GroupState<V>, group: &GroupTask<V>) -> [V::Mask; 4] {
    let preset = &config.preset.terminations;
    let reference = &group.reference;
    let anchor = &state.bodies[config.followed[config.anchor]];
    let target_rot = reference.rot(config.anchor);
    let away = anchor.pos - reference.pos(config.anchor);
    let distance2 = away.x().mul_add(away.x(), away.y() * away.y());
    let limit = preset.anchor_distance_m;
    let gravity = projected_gravity(&anchor.rot).z() - projected_gravity(&target_rot).z();
    let mut ends = V::zero();
    for &i in &config.end_effectors {
        // Alignment is a turn about z: the relative target's height is the reference's.
        let lift = state.bodies[config.followed[i]].pos.z() - reference.pos(i).z();
        ends = ends.max(lift.abs());
    }
    [
        exceeds(away.z().abs(), preset.anchor_height_m),
        exceeds(gravity.abs(), preset.gravity_z),
        exceeds(ends, preset.end_effector_height_m),
        exceeds(distance2, if limit > 0.0 { limit * limit } else { 0.0 }),
    ]
}

#[inline(always)]
fn exceeds<V: Real>(value: V, limit: f64) -> V::Mask {
    if limit > 0.0 { value.gt(V::c(limit)) } else { V::Mask::splat(false) }
}

/// True where every number that drives the next step is finite.
#[inline(always)]
fn finite<V: Real>(state: &GroupState<V>) -> V::Mask {
    let mut sum = V::zero();
    for j in 0..state.joint_pos.len() {
        sum += (state.joint_pos[j] + state.joint_vel[j]) * V::zero();
    }
    let base = &state.bodies[0];
    for v in [base.pos, base.lin_vel, base.ang_vel, state.ball.pos, state.ball.vel, state.ball.ang_vel] {
        sum += (v.x() + v.y() + v.z()) * V::zero();
    }
    sum.is_finite()
}
