//! Reward and failure of a group after a control step.

use paid_lanes::{Mask, Real, Vec3};
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::references::tracking::TrackingErrors;
use crate::scene::kick::KickStep;
use crate::terms::TermInput;
use crate::terms::rewards::REWARD_TERMS;
use crate::terms::terminations::TERMINATION_TERMS;
use crate::{TRACKING_NAMES, TaskPreset};

/// Sums over steps and groups, one number per lane.
#[derive(Clone, Debug)]
pub(crate) struct Sums<V> {
    pub terms: [V; REWARD_TERMS],
    /// The terms of other crates.
    pub own: Vec<V>,
    pub tracking: [V; TRACKING_NAMES.len()],
}

impl<V: Real> Sums<V> {
    pub(crate) fn new(preset: &TaskPreset) -> Self {
        Self {
            terms: [V::zero(); REWARD_TERMS],
            own: vec![V::zero(); preset.rewards.own.len()],
            tracking: [V::zero(); TRACKING_NAMES.len()],
        }
    }

    /// The sums of the reward terms, then those of the tracking errors.
    pub(crate) fn all_mut(&mut self) -> impl Iterator<Item = &mut V> {
        self.terms.iter_mut().chain(&mut self.own).chain(&mut self.tracking)
    }
}

/// Results of other crates' terms for a group's last step.
#[derive(Clone, Debug)]
pub(crate) struct OwnScore<V> {
    /// Value x weight x control period of each reward term.
    pub rewards: Vec<V>,
    /// Failures by each termination term, one bit per lane.
    pub failed: Vec<u32>,
}

impl<V: Real> OwnScore<V> {
    pub(crate) fn new(preset: &TaskPreset) -> Self {
        Self {
            rewards: vec![V::zero(); preset.rewards.own.len()],
            failed: vec![0; preset.terminations.own.len()],
        }
    }
}

/// Result of a control step; masks have one bit per lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Score<V> {
    /// Reward: the sum of term x weight x control period; 0 in lanes that are not finite.
    pub reward: V,
    /// Failures, in the order of the built-in terms.
    pub failed: [u32; TERMINATION_TERMS],
    /// A number of the state or the reward is not finite.
    pub not_finite: u32,
    /// First contact between robot and ball.
    pub first_contact: u32,
    /// It was by the labeled foot.
    pub correct: u32,
    /// The right foot is nearer to the ball.
    pub right: u32,
}

/// Scores the state against the group's reference and advances the kick.
#[inline(always)]
pub(crate) fn score<V: Real>(
    config: &TaskConfig,
    state: &GroupState<V>,
    group: &mut GroupTask<V>,
    tracking: &mut TrackingErrors<V>,
    sums: &mut Sums<V>,
    own: &mut OwnScore<V>,
) -> Score<V> {
    let preset = &config.preset.rewards;
    let mut errors = [V::zero(); TRACKING_NAMES.len()];
    if config.has_reference {
        tracking.update(config, state, &group.reference);
        errors = tracking.logged(config, state, &group.reference);
    }
    foot_peaks(config, state, group);
    let kick = if config.preset.scene.ball {
        let robot_points = [state.bodies[config.followed[config.anchor]].pos, state.bodies[0].pos];
        let feet = [0, 1].map(|side| (config.foot(state, side).pos, config.foot_body(side)));
        group.kick.advance(&state.ball, feet, robot_points, &preset.kick)
    } else {
        KickStep::none()
    };
    let mut terms = [V::zero(); REWARD_TERMS];
    let mut total = preset.evaluate(&TermInput { config, state, group, tracking, kick }, &mut terms);
    if !own.rewards.is_empty() {
        total += preset.own.evaluate(&TermInput { config, state, group, tracking, kick }, &mut own.rewards);
    }
    if config.preset.scene.ball {
        let half_width = 0.5 * config.preset.goal.width_m;
        let (goal, heading) = (group.goal, group.heading);
        group.kick.observe_outcome(&state.ball, goal, heading, preset.kick.window_steps, half_width);
    }
    if let Some(kept) = &mut group.terms {
        kept.clear();
        kept.extend_from_slice(&terms);
        kept.extend_from_slice(&own.rewards);
    }
    let finite = finite(state).and(total.is_finite());
    for (sum, term) in sums.terms.iter_mut().zip(terms) {
        *sum += V::select(finite, term, V::zero());
    }
    for (sum, term) in sums.own.iter_mut().zip(&own.rewards) {
        *sum += V::select(finite, *term, V::zero());
    }
    for (sum, error) in sums.tracking.iter_mut().zip(errors) {
        *sum += V::select(finite, error, V::zero());
    }
    let reward = V::select(finite, total, V::zero());
    group.episode_return += reward;
    let terminations = &config.preset.terminations;
    if !own.failed.is_empty() {
        terminations.own.evaluate(&TermInput { config, state, group, tracking, kick }, &mut own.failed);
    }
    Score {
        reward,
        failed: terminations.evaluate(&TermInput { config, state, group, tracking, kick }),
        not_finite: finite.not().bits(),
        first_contact: kick.first.bits(),
        correct: kick.correct.bits(),
        right: kick.right.bits(),
    }
}

/// Largest speeds of the labeled foot and of its reference; without a reference of the faster foot.
#[inline(always)]
fn foot_peaks<V: Real>(config: &TaskConfig, state: &GroupState<V>, group: &mut GroupTask<V>) {
    if !config.has_reference {
        for side in 0..2 {
            group.foot_peak = config.foot(state, side).com_vel.norm().max(group.foot_peak);
        }
        return;
    }
    let is_right = group.kick.label.gt(V::zero());
    let [left, right] = config.feet.map(|i| group.reference.com_vel(i));
    let kicking = Vec3::select(is_right, config.foot(state, 1).com_vel, config.foot(state, 0).com_vel);
    let wanted = Vec3::select(is_right, right, left);
    group.foot_peak = kicking.norm().max(group.foot_peak);
    group.reference_peak = wanted.norm().max(group.reference_peak);
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
