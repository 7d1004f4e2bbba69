//! A control step: act, simulate, score, end and count episodes.

use paid_lanes::Real;
use paid_lanes::rng::Rng;
use paid_physics::{GroupState, LateTargets, Simulator};

use super::{EnvTask, Task};
use crate::config::TaskConfig;
use crate::episode::reset::velocity_noise;
use crate::episode::stance::Stance;
use crate::group::GroupTask;
use crate::kernels::ScoreGroup;
use crate::kernels::act::Act;
use crate::kernels::score::Score;
use crate::{
    AfterEnd, AfterKick, AtMotionEnd, EndCause, KickEvent, OnFailure, SamplingStatistics, TaskMetrics,
};

/// Control steps after the contact at which a kick's ball velocity is taken.
const KICK_DELAY: u32 = 5;

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// Advances all environments, see [`paid_policy::VecEnv::step`].
    pub(crate) fn step_all(
        &mut self,
        actions: &[f32],
        reward: &mut [f32],
        terminated: &mut [u8],
        truncated: &mut [u8],
    ) {
        let envs = self.envs.len();
        assert_eq!(actions.len(), self.config.joints() * envs, "actions");
        assert!(reward.len() == envs && terminated.len() == envs && truncated.len() == envs, "step results");
        for group in 0..self.groups.len() {
            let first = group * V::LANES;
            self.push(group);
            self.remember(group, u32::MAX);
            V::run(Act {
                config: &self.config,
                group: &mut self.groups[group],
                actions,
                stride: envs,
                first,
                targets: &mut self.targets,
                before: &mut self.before,
            });
            match &self.groups[group].delays {
                Some(delays) => {
                    let late = delays.action;
                    self.sim.step_late(group, LateTargets { before: &self.before, now: &self.targets, late });
                }
                None => self.sim.step(group, &self.targets),
            }
            let score = V::run(ScoreGroup {
                config: &self.config,
                state: self.sim.state(group),
                group: &mut self.groups[group],
                tracking: &mut self.tracking,
                sums: &mut self.sums,
                own: &mut self.own,
                reward: &mut reward[first..first + V::LANES],
            });
            self.look(group);
            let resets = self.finish(group, &score, &mut terminated[first..], &mut truncated[first..]);
            if resets != 0 {
                self.reset_lanes(group, resets);
            }
            self.gather(group);
        }
        self.metrics.steps += envs as u64;
    }

    fn push(&mut self, group: usize) {
        if !self.config.preset.pushes.enabled || !self.disturbed() {
            return;
        }
        for lane in 0..V::LANES {
            let env = &mut self.envs[group * V::LANES + lane];
            env.push_in = env.push_in.saturating_sub(1);
            if env.push_in == 0 {
                let (linear, angular) =
                    velocity_noise(&self.config.preset.pushes.velocity, &mut env.push_rng);
                self.sim.push_lane(group, lane, linear, angular);
                env.push_in = push_interval(&self.config, &mut env.push_rng);
            }
        }
    }

    /// Advances references, decides which episodes end, and counts. Returns the lanes to reset.
    fn finish(&mut self, group: usize, score: &Score<V>, terminated: &mut [u8], truncated: &mut [u8]) -> u32 {
        let rules = self.rules;
        let limit = rules.max_steps(self.config.max_steps);
        let end_on_failure = rules.on_failure == OnFailure::End;
        let ends_with_motion = self.config.has_reference && rules.at_motion_end == AtMotionEnd::End;
        let mut resets = 0;
        for lane in 0..V::LANES {
            let index = group * V::LANES + lane;
            let bit = |mask: u32| mask >> lane & 1 == 1;
            let env = &mut self.envs[index];
            env.step += 1;
            record_kick(env, self.sim.state(group), lane, score, &self.config);
            let frames = self.library.facts()[env.motion].frames;
            let scored = env.frame;
            env.frame += 1;
            let builtin = EndCause::BUILTIN.into_iter().zip(score.failed);
            let own = (0..).map(EndCause::Own).zip(self.own.failed.iter().copied());
            let failure = || builtin.chain(own).find(|(_, mask)| bit(*mask));
            let cause = if bit(score.not_finite) {
                Some(EndCause::NotFinite)
            } else if let Some((cause, _)) = failure().filter(|_| end_on_failure) {
                Some(cause)
            } else if env.frame >= frames + env.hold && ends_with_motion {
                Some(EndCause::MotionEnd)
            } else if env.step >= limit
                || (rules.after_kick == AfterKick::AsPreset && stops_after_kick(env, &self.config))
            {
                Some(EndCause::TimeOut)
            } else {
                None
            };
            let newly_ended = env.ended.is_none();
            let cause = env.ended.or(cause);
            let failed = cause.is_some_and(EndCause::is_failure);
            terminated[lane] = u8::from(failed);
            truncated[lane] = u8::from(cause.is_some() && !failed);
            let Some(cause) = cause else { continue };
            if newly_ended && rules.sampling == SamplingStatistics::Counted {
                let bins = self.sampler.bins;
                let pair =
                    |frame: usize| env.motion * bins + (frame.min(frames - 1) * bins / frames).min(bins - 1);
                let miss = self.config.preset.sampling.miss_sampling_weight as f32;
                if failed {
                    self.failures[pair(scored)] += 1.0;
                } else if miss > 0.0
                    && !env.after_strike
                    && self.groups[group].kick.on_target.lane(lane) < 0.5
                {
                    self.failures[pair(self.library.facts()[env.motion].strike_frame)] += miss;
                }
            }
            if newly_ended {
                count_episode(&mut self.metrics, &self.config, env, &self.groups[group], lane, cause);
            }
            if rules.after_end == AfterEnd::Restart {
                resets |= 1 << lane;
            } else if bit(score.not_finite) {
                // The lane must become finite again; what it reports stays the failure.
                self.reset_lanes(group, 1 << lane);
                self.envs[index].ended = Some(cause);
            } else {
                env.ended = Some(cause);
            }
            let kept = self.config.preset.sampling.from_end_state_share > 0.0;
            if newly_ended && kept && cause == EndCause::MotionEnd {
                self.keep_end_state(group, lane);
            }
        }
        resets
    }

    /// Keeps the state of a robot that has been held to the end, for other episodes to begin in.
    fn keep_end_state(&mut self, group: usize, lane: usize) {
        let state = self.sim.state(group);
        let [x, y, _] = state.bodies[self.config.followed[self.config.anchor]].pos.lane(lane);
        let ground = self.sim.ground_height(group, lane, [x, y]);
        let quat = self.sim.save_lane(group, lane).base_quat;
        self.end_states.push(Stance::of_lane(&self.config, state, lane, quat, ground));
    }
}

/// True once the preset ends a training episode because of the time since its kick.
fn stops_after_kick(env: &EnvTask, config: &TaskConfig) -> bool {
    let preset = &config.preset.sampling;
    let Some(kick) = env.kick.as_ref().filter(|_| preset.stop_after_kick_s > 0.0) else { return false };
    // Multiples of the golden ratio fill the unit interval evenly: any run of environments holds the share.
    let place = (f64::from(env.id) * 0.618_033_988_749_894_9).fract();
    let steps = (preset.stop_after_kick_s / config.dt_s).round();
    place < preset.stop_share && f64::from(env.step - kick.step) >= steps
}

pub(super) fn push_interval(config: &TaskConfig, rng: &mut Rng) -> u32 {
    let [lo, hi] = config.preset.pushes.interval_s;
    ((rng.uniform(lo, hi) / config.dt_s).round() as u32).max(1)
}

fn record_kick<V: Real>(
    env: &mut EnvTask,
    state: &GroupState<V>,
    lane: usize,
    score: &Score<V>,
    config: &TaskConfig,
) {
    if score.first_contact >> lane & 1 == 1 {
        let foot = (score.right >> lane & 1) as usize;
        let body = state.ball.touched_by.lane(lane);
        env.kick = Some(KickEvent {
            step: env.step,
            foot,
            correct: score.correct >> lane & 1 == 1,
            body: (body >= 0.0).then_some(body as usize),
            foot_vel: state.bodies[config.followed[config.feet[foot]]].com_vel.lane(lane),
            ball_vel_after: None,
        });
    } else if let Some(kick) = &mut env.kick
        && env.step == kick.step + KICK_DELAY
    {
        kick.ball_vel_after = Some(state.ball.vel.lane(lane));
    }
}

fn count_episode<V: Real>(
    metrics: &mut TaskMetrics,
    config: &TaskConfig,
    env: &EnvTask,
    group: &GroupTask<V>,
    lane: usize,
    cause: EndCause,
) {
    metrics.episodes += 1;
    metrics.episode_steps += u64::from(env.step);
    metrics.ends[cause.index()] += 1;
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    metrics.episode_return_sum += finite(group.episode_return.lane(lane));
    metrics.kick_foot_peak_sum += finite(group.foot_peak.lane(lane));
    metrics.reference_foot_peak_sum += finite(group.reference_peak.lane(lane));
    if !config.preset.scene.ball || env.after_strike {
        return;
    }
    let (counts, kick) = (&mut metrics.kick, &group.kick);
    let is = |flag: V| u64::from(flag.lane(lane) > 0.5);
    counts.episodes += 1;
    counts.contacts += is(kick.touched);
    counts.correct_foot += is(kick.correct);
    counts.goals += is(kick.scored);
    counts.on_target += is(kick.on_target);
    counts.ball_speed_sum += finite(kick.best_speed.lane(lane));
    counts.ball_cosine_sum += finite(kick.best_cosine.lane(lane));
}
