//! The task over an engine: all environments of a shard, and how their episodes begin. What they show is in `observe`, a control
//! step in `step`.

mod image;
mod next_kick;
mod observe;
mod shard_impl;
mod snapshot;
mod step;

use std::sync::Arc;

use paid_lanes::rng::Rng;
use paid_lanes::{MAX_LANES, Real};
use paid_physics::{EnvParams, Simulator};
use paid_play::{KickTimes, ReferenceLibrary};
use paid_track::effective_time;

use crate::config::TaskConfig;
use crate::episode::eyes::begin_lane;
use crate::episode::reset::{Start, StartContext};
use crate::episode::stance::EndStates;
use crate::group::GroupTask;
use crate::kernels::Gather;
use crate::kernels::observe::RobotBuffer;
use crate::kernels::score::{OwnScore, Sums};
use crate::references::anchoring::Anchoring;
use crate::references::tracking::TrackingErrors;
use crate::scene::eyes::start_rng;
use crate::scene::rolling::roll_decay;
use crate::task::image::Image;
use crate::{
    BallCurriculum, Disturbances, EndCause, EpisodeRules, InitialState, KickEvent, SamplerState, TaskError,
    TaskMetrics, TaskSetup,
};
use step::push_interval;

/// Purposes of an environment's random streams (2 is observation noise, 5 to 7 are the eyes).
const RESET_STREAM: u32 = 0;
const PUSH_STREAM: u32 = 1;
const START_STREAM: u32 = 8;
/// The time to the strike where no reference says one `[s]`: outside of every window around it, so that the tracker expects no strike.
const NO_STRIKE_S: f64 = f64::INFINITY;
/// Groups whose observations are written out together.
const BLOCK_GROUPS: usize = 8;

/// What the task remembers of one environment outside the lanes.
#[derive(Clone, Debug)]
pub(crate) struct EnvTask {
    /// Number of the environment over all shards.
    pub id: u32,
    pub motion: usize,
    /// Frame that the next state is scored against; it runs on beyond the motion's last one.
    pub frame: usize,
    /// For how long the last frame is held [control steps].
    pub hold: usize,
    /// True if the episode began after the strike.
    pub after_strike: bool,
    /// Where the motion begins, if the robot went on from where it stood.
    pub anchoring: Option<Anchoring>,
    /// Control steps since the episode began.
    pub step: u32,
    /// Control steps until the next push.
    pub push_in: u32,
    pub reset_rng: Rng,
    pub push_rng: Rng,
    /// Holding and starts other than a frame's.
    pub start_rng: Rng,
    pub params: EnvParams,
    /// Evaluation: where episodes begin.
    pub forced: Option<InitialState>,
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
    pub(crate) curriculum: BallCurriculum,
    pub(crate) failures: Vec<f32>,
    pub(crate) end_states: EndStates,
    tracking: TrackingErrors<V>,
    pub(crate) sums: Sums<V>,
    own: OwnScore<V>,
    pub(crate) metrics: TaskMetrics,
    pub(crate) seed: u64,
    /// Observations made so far: the position in the noise streams.
    pub(crate) observations: u64,
    pub(crate) rules: EpisodeRules,
    targets: Vec<V>,
    before: Vec<V>,
    /// Numbers of the last noise drawn.
    noise: Vec<V>,
    /// Robot of the group that is being observed.
    robot: RobotBuffer<V>,
    /// Observations of [`BLOCK_GROUPS`] groups on their way out.
    policy_rows: Vec<f32>,
    critic_rows: Vec<f32>,
    style_rows: Vec<f32>,
    teacher_rows: Vec<f32>,
    /// `None` if the policy sees left-footed kicks as they are.
    pub(crate) image: Option<Image>,
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// A task over `sim`, whose model must be the setup's robot and whose scene the preset's. Every environment begins an episode.
    ///
    /// # Errors
    /// If preset, robot, library and simulator do not fit together.
    pub fn new(sim: S, setup: &TaskSetup<'_>) -> Result<Self, TaskError> {
        let TaskSetup { robot, spec, library, preset, first_env, seed } = *setup;
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
                hold: 0,
                after_strike: false,
                anchoring: None,
                step: 0,
                push_in: u32::MAX,
                reset_rng: Rng::new(seed, id, RESET_STREAM),
                push_rng: Rng::new(seed, id, PUSH_STREAM),
                start_rng: Rng::new(seed, id, START_STREAM),
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
            curriculum: BallCurriculum::default(),
            failures: vec![0.0; library.len() * library.bins()],
            end_states: EndStates::default(),
            tracking: TrackingErrors::new(&config),
            sums: Sums::new(preset),
            own: OwnScore::new(preset),
            metrics: TaskMetrics::default(),
            seed,
            observations: 0,
            rules: EpisodeRules::TRAINING,
            targets: vec![V::zero(); config.joints()],
            before: vec![V::zero(); config.joints()],
            noise: vec![V::zero(); config.observations.noisy],
            robot: RobotBuffer::new(&config),
            policy_rows: vec![0.0; config.layout.policy_dim() * BLOCK_GROUPS * V::LANES],
            critic_rows: vec![0.0; config.layout.critic_dim() * BLOCK_GROUPS * V::LANES],
            style_rows: vec![0.0; config.observations.style_dim * BLOCK_GROUPS * V::LANES],
            teacher_rows: vec![0.0; config.observations.teacher_dim * BLOCK_GROUPS * V::LANES],
            library: Arc::clone(library),
            image: Image::new(&config)?,
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
        self.rules.disturbances == Disturbances::AsPreset
    }

    /// Begins new episodes in the lanes whose bit is set. [`Task::gather`] must follow.
    pub(crate) fn reset_lanes(&mut self, group: usize, lanes: u32) {
        let randomize = self.disturbed();
        for lane in (0..V::LANES).filter(|l| lanes >> l & 1 == 1) {
            let env = &mut self.envs[group * V::LANES + lane];
            let reset_position = env.forced.is_none().then(|| env.reset_rng.position());
            let mut eyes_rng = start_rng(self.seed, env.id, reset_position);
            let context = StartContext {
                eyes: self.config.preset.perceives().then_some(eyes_rng),
                config: &self.config,
                library: &self.library,
                sampler: &self.sampler,
                curriculum: self.curriculum,
                end_states: &self.end_states,
                forced: env.forced.as_ref(),
                env: env.id,
                randomize,
            };
            let start =
                context.draw::<V, S>(&mut self.sim, [group, lane], &mut env.reset_rng, &mut env.start_rng);
            self.sim.reset_lane(group, lane, &start.state);
            let facts = &self.library.facts()[start.motion];
            env.motion = start.motion;
            env.frame = start.frame + 1;
            env.hold = start.hold;
            env.after_strike = start.struck.is_some();
            env.anchoring = None;
            env.step = 0;
            env.ended = None;
            env.kick = None;
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
            let wait = self.config.no_kick_before(facts, start.frame);
            let kick_foot = self.config.has_reference.then_some(facts.kick_foot);
            task.kick.reset_lane(lane, kick_foot, start.state.ball_pos, wait);
            if let Some(struck) = &start.struck {
                task.kick.set_struck(lane, struck.distance2);
            }
            task.episode_return.set_lane(lane, 0.0);
            task.foot_peak.set_lane(lane, 0.0);
            task.reference_peak.set_lane(lane, 0.0);
            begin_to_see(task, lane, &start, &mut env.reset_rng);
            if let Some(eyes) = &mut task.eyes {
                begin_lane(eyes, lane, &start, facts.heading, &self.config, &mut eyes_rng);
            }
            if let Some(delays) = &mut task.delays {
                delays.reset_lane(lane, start.delays);
            }
            env.params = start.params;
        }
        if let Some(anchoring) = &mut self.groups[group].anchoring {
            for lane in (0..V::LANES).filter(|l| lanes >> l & 1 == 1) {
                anchoring.set_lane(lane, None);
            }
        }
        self.sim.refresh(group);
        self.remember(group, lanes);
    }

    /// Loads every lane's reference frame and takes in what is seen.
    pub(crate) fn gather(&mut self, group: usize) {
        self.gather_reference(group);
    }

    /// Loads every lane's reference frame.
    pub(crate) fn gather_reference(&mut self, group: usize) {
        let (mut motions, mut frames) = ([0; MAX_LANES], [0; MAX_LANES]);
        for lane in 0..V::LANES {
            let env = &self.envs[group * V::LANES + lane];
            (motions[lane], frames[lane]) = (env.motion, env.frame);
            let facts = &self.library.facts()[env.motion];
            let KickTimes { to_strike_s, to_contact_s } = facts.times_from(env.frame, self.config.dt_s);
            let to_strike_s = if self.config.has_reference { to_strike_s } else { NO_STRIKE_S };
            self.groups[group].to_strike_s.set_lane(lane, to_strike_s);
            self.groups[group].to_contact_s.set_lane(lane, to_contact_s);
            if self.config.observations.predicts {
                // The policy sees the frame after the state's.
                let wait = to_contact_s + self.config.dt_s;
                let prediction_s = effective_time(wait, roll_decay(&env.params.ball));
                self.groups[group].prediction_s.set_lane(lane, prediction_s);
            }
        }
        V::run(Gather {
            library: &self.library,
            group: &mut self.groups[group],
            anchor: self.config.anchor,
            motions,
            frames,
        });
    }
}

/// Ball and goal appear to one lane's robot.
pub(crate) fn begin_to_see<V: Real>(task: &mut GroupTask<V>, lane: usize, start: &Start, rng: &mut Rng) {
    // Earlier versions drew two numbers here; the same seed is to give the same episodes.
    let _ = [rng.unit(), rng.unit()];
    let place = start.struck.map_or(start.state.ball_pos, |struck| struck.lay);
    for memory in &mut task.scene_memory {
        memory.reset_lane(lane, place);
    }
}
