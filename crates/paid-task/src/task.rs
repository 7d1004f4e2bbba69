//! The task over an engine: one control step of all environments of a shard.

use std::sync::Arc;

use paid_lanes::rng::Rng;
use paid_lanes::{Real, Vec3};
use paid_physics::{EnvParams, GroupState, Simulator};
use paid_robot::{RobotModel, RobotSpec};

use crate::config::TaskConfig;
use crate::group::GroupTask;
use crate::kernels::{Act, Gather, Observe, ScoreGroup};
use crate::lead::{self, roll_decay, way_s};
use crate::observe::{Draw, Seen, in_base, noise_len};
use crate::perception::deviation;
use crate::reference::MAX_LANES;
use crate::reset::{StartContext, velocity_noise};
use crate::score::{Score, Sums};
use crate::{
    EndCause, EvalOptions, ForcedStart, KickEvent, ReferenceLibrary, SamplerState, TaskError, TaskMetrics,
    TaskPreset,
};

/// Purposes of an environment's random streams (2 is observation noise).
const RESET_STREAM: u32 = 0;
const PUSH_STREAM: u32 = 1;
const PERCEPTION_STREAM: u32 = 3;
const VELOCITY_STREAM: u32 = 4;
/// Control steps after the contact at which a kick's ball velocity is taken.
const KICK_DELAY: u32 = 5;

/// Groups whose observations are written out together.
const BLOCK_GROUPS: usize = 8;

/// What the task remembers of one environment outside the lanes.
#[derive(Clone, Debug)]
pub(crate) struct EnvTask {
    /// Number of the environment over all shards.
    pub id: u32,
    pub motion: usize,
    /// Frame that the next state is scored against.
    pub frame: usize,
    /// Control steps since the episode began.
    pub step: u32,
    /// Control steps until the next push.
    pub push_in: u32,
    pub reset_rng: Rng,
    pub push_rng: Rng,
    pub params: EnvParams,
    /// Evaluation: where episodes begin.
    pub forced: Option<ForcedStart>,
    /// Evaluation without automatic reset: how the episode ended.
    pub ended: Option<EndCause>,
    /// First kick of the episode.
    pub kick: Option<KickEvent>,
}

/// The task over any engine, `V::LANES` environments a group.
pub struct Task<V: Real, S: Simulator<V>> {
    pub(crate) sim: S,
    pub(crate) config: TaskConfig,
    pub(crate) library: Arc<ReferenceLibrary>,
    pub(crate) groups: Vec<GroupTask<V>>,
    pub(crate) envs: Vec<EnvTask>,
    pub(crate) sampler: SamplerState,
    pub(crate) failures: Vec<f32>,
    pub(crate) sums: Sums<V>,
    pub(crate) metrics: TaskMetrics,
    pub(crate) seed: u64,
    /// Observations made so far: the position in the noise streams.
    pub(crate) observations: u64,
    pub(crate) eval: Option<EvalOptions>,
    targets: Vec<V>,
    /// Numbers of the last noise drawn.
    noise: Vec<V>,
    /// Observations of [`BLOCK_GROUPS`] groups on their way out.
    policy_rows: Vec<f32>,
    critic_rows: Vec<f32>,
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// A task over `sim`, whose model must be `robot` and whose scene the preset's. Every environment begins an episode.
    ///
    /// # Errors
    /// If preset, robot, library and simulator do not fit together.
    pub fn new(
        sim: S,
        robot: &RobotModel,
        spec: &RobotSpec,
        library: &Arc<ReferenceLibrary>,
        preset: &TaskPreset,
        first_env: usize,
        seed: u64,
    ) -> Result<Self, TaskError> {
        let control = spec.resolve(robot).map_err(|e| TaskError::Robot(e.to_string()))?;
        let config = TaskConfig::new(robot, spec, control, library, preset)?;
        assert!(V::LANES <= MAX_LANES, "lane types have at most {MAX_LANES} lanes");
        if sim.model().body_names() != robot.body_names() {
            return Err(TaskError::Simulator("it simulates another robot".into()));
        }
        if (sim.control_dt_s() - config.dt_s).abs() > 1e-9 {
            return Err(TaskError::Simulator(format!(
                "its control period is {} s, the preset's {} s",
                sim.control_dt_s(),
                config.dt_s
            )));
        }
        let groups = sim.groups();
        let envs = (0..groups * V::LANES).map(|e| {
            let id = (first_env + e) as u32;
            EnvTask {
                id,
                motion: 0,
                frame: 1,
                step: 0,
                push_in: u32::MAX,
                reset_rng: Rng::new(seed, id, RESET_STREAM),
                push_rng: Rng::new(seed, id, PUSH_STREAM),
                params: EnvParams::default(),
                forced: None,
                ended: None,
                kick: None,
            }
        });
        let mut task = Self {
            groups: vec![GroupTask::new(&config, library.layout()); groups],
            envs: envs.collect(),
            sampler: SamplerState::uniform(library.len(), library.bins()),
            failures: vec![0.0; library.len() * library.bins()],
            sums: Sums::new(),
            metrics: TaskMetrics::default(),
            seed,
            observations: 0,
            eval: None,
            targets: vec![V::zero(); config.joints()],
            noise: vec![V::zero(); noise_len(config.joints())],
            policy_rows: vec![0.0; config.layout.policy_dim() * BLOCK_GROUPS * V::LANES],
            critic_rows: vec![0.0; config.layout.critic_dim() * BLOCK_GROUPS * V::LANES],
            library: Arc::clone(library),
            config,
            sim,
        };
        for group in 0..groups {
            task.reset_lanes(group, (1_u32 << V::LANES) - 1);
            task.gather(group);
        }
        Ok(task)
    }

    /// The engine.
    pub fn simulator(&self) -> &S {
        &self.sim
    }

    fn disturbed(&self) -> bool {
        self.eval.is_none_or(|e| e.disturbances)
    }

    /// Begins new episodes in the lanes whose bit is set. [`Task::gather`] must follow.
    pub(crate) fn reset_lanes(&mut self, group: usize, lanes: u32) {
        let randomise = self.disturbed();
        for lane in (0..V::LANES).filter(|l| lanes >> l & 1 == 1) {
            let env = &mut self.envs[group * V::LANES + lane];
            let context = StartContext {
                config: &self.config,
                library: &self.library,
                sampler: &self.sampler,
                forced: env.forced.as_ref(),
                env: env.id,
                randomise,
            };
            let start = context.draw::<V, S>(&mut self.sim, group, lane, &mut env.reset_rng);
            self.sim.reset_lane(group, lane, &start.state);
            let facts = &self.library.facts()[start.motion];
            env.motion = start.motion;
            env.frame = start.frame + 1;
            env.step = 0;
            env.ended = None;
            env.kick = None;
            env.params = start.params;
            env.push_in = push_interval(&self.config, &mut env.push_rng);
            let task = &mut self.groups[group];
            for j in 0..self.config.joints() {
                task.action[j].set_lane(lane, 0.0);
                task.previous[j].set_lane(lane, 0.0);
                task.joint_offset[j].set_lane(lane, start.joint_offset[j]);
            }
            task.goal.set_lane(lane, start.goal);
            task.heading[0].set_lane(lane, facts.heading.cos());
            task.heading[1].set_lane(lane, facts.heading.sin());
            let early_s = self.config.preset.rewards.kick.early_s;
            let early = (early_s / self.config.dt_s).round() as usize;
            // The episode's first step is scored against the frame after the start.
            let wait = facts.strike_frame.saturating_sub(early + start.frame + 1);
            let wait = if early_s > 0.0 { wait } else { 0 };
            task.kick.reset_lane(lane, facts.kick_foot, start.state.ball_pos, wait);
            task.episode_return.set_lane(lane, 0.0);
            task.foot_peak.set_lane(lane, 0.0);
            task.reference_peak.set_lane(lane, 0.0);
            let base = paid_lanes::Quat(start.state.base_quat);
            let local = |point: [f64; 3]| base.conj().rotate(Vec3(point) - Vec3(start.state.base_pos)).0;
            let (ball, goal) = (local(start.state.ball_pos), local(start.goal));
            let perception = &self.config.preset.observations.perception;
            task.perception.reset_lane(lane, ball, perception, &mut env.reset_rng);
            if let Some(pictures) = &mut task.pictures {
                pictures.reset_lane(lane, [ball, goal], &self.config, &mut env.reset_rng);
            }
            if let Some(late) = &mut task.late {
                late.reset_lane(lane, start.delays);
            }
        }
        self.sim.refresh(group);
        if self.groups[group].late.is_some() {
            let state = self.sim.state(group);
            self.groups[group].remember(&self.config, state, lanes);
        }
    }

    /// Loads every lane's reference frame and takes in what is seen.
    pub(crate) fn gather(&mut self, group: usize) {
        self.gather_reference(group);
        if self.config.preset.observations.perception.blind_zone {
            let state = self.sim.state(group);
            self.groups[group].perception.advance(in_base(state, state.ball.pos));
        }
    }

    /// Loads every lane's reference frame.
    pub(crate) fn gather_reference(&mut self, group: usize) {
        let (mut motions, mut frames) = ([0; MAX_LANES], [0; MAX_LANES]);
        for lane in 0..V::LANES {
            let env = &self.envs[group * V::LANES + lane];
            (motions[lane], frames[lane]) = (env.motion, env.frame);
            let strike = self.library.facts()[env.motion].strike_frame;
            let to_strike_s = (strike as f64 - env.frame as f64) * self.config.dt_s;
            self.groups[group].to_strike_s.set_lane(lane, to_strike_s);
            if self.config.preset.observations.lead_ball {
                // The policy sees the frame after the state's.
                let lead_s = way_s(to_strike_s + self.config.dt_s, roll_decay(&env.params.ball));
                self.groups[group].lead_s.set_lane(lane, lead_s);
            }
        }
        V::run(Gather { library: &self.library, group: &mut self.groups[group], motions, frames });
    }

    /// Writes observations, see [`crate::TaskShard::observe`].
    pub(crate) fn observe_all(&mut self, policy: &mut [f32], critic: &mut [f32]) {
        let envs = self.envs.len();
        assert_eq!(policy.len(), self.config.layout.policy_dim() * envs, "policy observations");
        assert_eq!(critic.len(), self.config.layout.critic_dim() * envs, "critic observations");
        let disturbed = self.disturbed();
        if !disturbed {
            self.noise.fill(V::zero());
        }
        // A group's rows are 32 or 64 bytes, `envs` numbers apart: written through a small matrix of a few groups, so that
        // the large one receives longer runs and its rows do not fight for the same cache sets.
        let width = BLOCK_GROUPS * V::LANES;
        for block in 0..self.groups.len().div_ceil(BLOCK_GROUPS) {
            let first = block * BLOCK_GROUPS;
            let groups = BLOCK_GROUPS.min(self.groups.len() - first);
            for group in first..first + groups {
                self.observe_group(group, disturbed, (group - first) * V::LANES, width);
            }
            let used = groups * V::LANES;
            for (out, rows) in [(&mut *policy, &self.policy_rows), (&mut *critic, &self.critic_rows)] {
                for (to, from) in out.chunks_exact_mut(envs).zip(rows.chunks_exact(width)) {
                    to[first * V::LANES..][..used].copy_from_slice(&from[..used]);
                }
            }
        }
        self.observations += 1;
    }

    fn observe_group(&mut self, group: usize, disturbed: bool, first: usize, stride: usize) {
        let mut ids = [0; MAX_LANES];
        for lane in 0..V::LANES {
            ids[lane] = self.envs[group * V::LANES + lane].id;
        }
        let seen = self.misperceived(group);
        V::run(Observe {
            config: &self.config,
            state: self.sim.state(group),
            group: &self.groups[group],
            seen,
            draw: Draw {
                envs: if disturbed { &ids[..V::LANES] } else { &[] },
                seed: self.seed,
                count: self.observations,
                values: &mut self.noise,
            },
            policy: &mut self.policy_rows,
            critic: &mut self.critic_rows,
            stride,
            first,
        });
    }

    /// True if the policy does not see ball and goal as they are.
    fn misperceives(&self) -> bool {
        let preset = &self.config.preset.observations.perception;
        (self.disturbed() || preset.in_evaluation) && preset.errs()
    }

    /// Takes the pictures of this control step.
    fn look(&mut self, group: usize) {
        if !self.misperceives() || self.groups[group].pictures.is_none() {
            return;
        }
        let mut rngs = Vec::with_capacity(V::LANES);
        for lane in 0..V::LANES {
            let mut rng = Rng::new(self.seed, self.envs[group * V::LANES + lane].id, PERCEPTION_STREAM);
            rng.seek(self.observations * 16);
            rngs.push(rng);
        }
        self.groups[group].look(&self.config, self.sim.state(group), &mut rngs);
    }

    /// Ball and goal as the policy sees them where that differs from the truth: the ball is held outside the perceived band,
    /// both carry Gaussian noise.
    fn misperceived(&self, group: usize) -> Option<Seen<V>> {
        let preset = &self.config.preset.observations.perception;
        if !self.misperceives() {
            return None;
        }
        let (state, task) = (self.sim.state(group), &self.groups[group]);
        let mut seen = Seen { ball: in_base(state, state.ball.pos), goal: in_base(state, task.goal) };
        if let Some(pictures) = &task.pictures {
            seen = pictures.seen();
        } else if preset.blind_zone {
            seen.ball = task.perception.ball;
        }
        if self.config.preset.observations.lead_ball {
            let mut velocity = state.ball.vel;
            if preset.gaussian {
                for lane in 0..V::LANES {
                    let id = self.envs[group * V::LANES + lane].id;
                    let mut rng = Rng::new(self.seed, id, VELOCITY_STREAM);
                    rng.seek(self.observations * 4);
                    let [x, y, z] = velocity.lane(lane);
                    let mut estimate = |v: f64| v + preset.ball_velocity_m_s * rng.normal();
                    velocity.set_lane(lane, [estimate(x), estimate(y), z]);
                }
            }
            seen.ball += state.bodies[0].rot.tr_mul_vec(lead::way(velocity, task.lead_s));
        }
        if preset.gaussian && task.pictures.is_none() {
            let base = &state.bodies[0];
            let ball_speed = (state.ball.vel - base.lin_vel).norm();
            let deviations = [
                deviation(ball_speed, seen.ball.norm(), preset),
                deviation(base.lin_vel.norm(), seen.goal.norm(), preset),
            ];
            for lane in 0..V::LANES {
                let id = self.envs[group * V::LANES + lane].id;
                let mut rng = Rng::new(self.seed, id, PERCEPTION_STREAM);
                // Six normal numbers use 12 words.
                rng.seek(self.observations * 16);
                for (object, sigma) in [&mut seen.ball, &mut seen.goal].into_iter().zip(&deviations) {
                    let sigma = sigma.lane(lane);
                    let exact = object.lane(lane);
                    object.set_lane(lane, exact.map(|x| x + sigma * rng.normal()));
                }
            }
        }
        Some(seen)
    }

    /// Advances all environments, see [`crate::TaskShard::step`].
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
            if self.groups[group].late.is_some() {
                self.groups[group].remember(&self.config, self.sim.state(group), u32::MAX);
            }
            V::run(Act {
                config: &self.config,
                group: &mut self.groups[group],
                actions,
                stride: envs,
                first,
                targets: &mut self.targets,
            });
            self.sim.step(group, &self.targets);
            let score = V::run(ScoreGroup {
                config: &self.config,
                state: self.sim.state(group),
                group: &mut self.groups[group],
                sums: &mut self.sums,
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
        let [anchor, gravity, ends, distance, not_finite] = score.failed;
        let eval = self.eval;
        let limit = eval.and_then(|e| e.max_steps).unwrap_or(self.config.max_steps);
        let hold = eval.is_some_and(|e| e.hold_last_frame);
        let judge = eval.is_none_or(|e| e.end_on_failure);
        let mut resets = 0;
        for lane in 0..V::LANES {
            let index = group * V::LANES + lane;
            let bit = |mask: u32| mask >> lane & 1 == 1;
            let env = &mut self.envs[index];
            env.step += 1;
            record_kick(env, self.sim.state(group), lane, score, &self.config);
            let frames = self.library.facts()[env.motion].frames;
            let scored = env.frame;
            env.frame = (env.frame + 1).min(frames);
            let cause = if bit(not_finite) {
                Some(EndCause::NotFinite)
            } else if judge && bit(anchor) {
                Some(EndCause::AnchorHeight)
            } else if judge && bit(gravity) {
                Some(EndCause::Gravity)
            } else if judge && bit(ends) {
                Some(EndCause::EndEffector)
            } else if judge && bit(distance) {
                Some(EndCause::AnchorDistance)
            } else if env.frame >= frames && !hold {
                Some(EndCause::MotionEnd)
            } else if env.step >= limit || (eval.is_none() && stops_after_kick(env, &self.config)) {
                Some(EndCause::TimeOut)
            } else {
                None
            };
            let news = env.ended.is_none();
            let cause = env.ended.or(cause);
            let failed = cause.is_some_and(|c| c <= EndCause::NotFinite);
            terminated[lane] = u8::from(failed);
            truncated[lane] = u8::from(cause.is_some() && !failed);
            let Some(cause) = cause else { continue };
            if news && eval.is_none() {
                let bins = self.sampler.bins;
                let pair =
                    |frame: usize| env.motion * bins + (frame.min(frames - 1) * bins / frames).min(bins - 1);
                let miss = self.config.preset.sampling.miss_weight as f32;
                if failed {
                    self.failures[pair(scored)] += 1.0;
                } else if miss > 0.0 && self.groups[group].kick.on_target.lane(lane) < 0.5 {
                    self.failures[pair(self.library.facts()[env.motion].strike_frame)] += miss;
                }
            }
            if news {
                count_episode(&mut self.metrics, &self.config, env, &self.groups[group], lane, cause);
            }
            if eval.is_none_or(|e| e.auto_reset) {
                resets |= 1 << lane;
            } else if bit(not_finite) {
                // The lane must become finite again; what it reports stays the failure.
                self.reset_lanes(group, 1 << lane);
                self.envs[index].ended = Some(cause);
            } else {
                env.ended = Some(cause);
            }
        }
        resets
    }
}

/// True once the kick of a training episode is so long ago that the preset ends it.
fn stops_after_kick(env: &EnvTask, config: &TaskConfig) -> bool {
    let preset = &config.preset.sampling;
    let Some(kick) = env.kick.as_ref().filter(|_| preset.stop_after_kick_s > 0.0) else { return false };
    // Multiples of the golden ratio fill the unit interval evenly: any run of environments holds the share.
    let place = (f64::from(env.id) * 0.618_033_988_749_894_9).fract();
    let steps = (preset.stop_after_kick_s / config.dt_s).round();
    place < preset.stop_share && f64::from(env.step - kick.step) >= steps
}

fn push_interval(config: &TaskConfig, rng: &mut Rng) -> u32 {
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
    metrics.ends[cause as usize] += 1;
    let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
    metrics.episode_return_sum += finite(group.episode_return.lane(lane));
    metrics.kick_foot_peak_sum += finite(group.foot_peak.lane(lane));
    metrics.reference_foot_peak_sum += finite(group.reference_peak.lane(lane));
    if !config.preset.scene.ball {
        return;
    }
    let (kick, story) = (&mut metrics.kick, &group.kick);
    let is = |flag: V| u64::from(flag.lane(lane) > 0.5);
    kick.episodes += 1;
    kick.contacts += is(story.touched);
    kick.correct_foot += is(story.correct);
    kick.goals += is(story.scored);
    kick.on_target += is(story.on_target);
    kick.ball_speed_sum += finite(story.best_speed.lane(lane));
    kick.ball_cosine_sum += finite(story.best_cosine.lane(lane));
}
