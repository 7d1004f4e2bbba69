//! [`VecEnv`], [`TaskShard`] and [`EvalControl`] for any task.

use paid_lanes::Real;
use paid_physics::Simulator;
use paid_policy::action::joint_target;
use paid_policy::{Mirrors, ObservationGroup, ObservationLayout, StepBuffers, VecEnv};

use super::image;
use crate::episode::stance::heading_of;
use crate::group::GroupTask;
use crate::kernels::score::Sums;
use crate::scene::eyes::believed_ball;
use crate::scene::shown::ShownScene;
use crate::task::EnvTask;
use crate::{
    BallCurriculum, BelievedBall, BodySample, Disturbance, EnvSample, EpisodeRules, EvalControl,
    InitialState, NextKick, RewardTermsInSamples, SamplerState, Shown, Task, TaskError, TaskMetrics,
    TaskShard, TrainShard, reward_names,
};

impl<V: Real, S: Simulator<V>> VecEnv for Task<V, S> {
    fn num_envs(&self) -> usize {
        self.envs.len()
    }
    fn observation_groups(&self) -> Vec<ObservationGroup> {
        self.groups_shown().into_iter().map(|(name, size)| ObservationGroup::new(name, size)).collect()
    }
    fn action_dim(&self) -> usize {
        self.config.joints()
    }
    fn mirrors(&self) -> Result<Mirrors, String> {
        image::mirrors(&self.config)
    }
    fn observe(&mut self, groups: &mut [&mut [f32]]) {
        self.observe_all(groups);
        if let Some(image) = &mut self.image {
            let lists = &self.config.observations;
            let teacher = (lists.teacher_dim > 0).then(|| 2 + usize::from(lists.style_dim > 0));
            image.show(groups, teacher, &self.envs, self.library.facts());
        }
    }
    fn step(&mut self, actions: &[f32], out: StepBuffers<'_>) {
        // Taken out while the task steps.
        let mut image = self.image.take();
        let actions = match &mut image {
            Some(image) => image.act(actions, &self.envs, self.library.facts()),
            None => actions,
        };
        self.step_all(actions, out.reward, out.terminated, out.truncated);
        self.image = image;
    }
    fn save(&self) -> Vec<u8> {
        self.save_bytes()
    }
    fn restore(&mut self, bytes: &[u8]) -> Result<(), String> {
        self.restore_bytes(bytes)
    }
}

impl<V: Real, S: Simulator<V>> TrainShard for Task<V, S> {
    fn take_metrics(&mut self) -> TaskMetrics {
        self.fold_sums();
        std::mem::take(&mut self.metrics)
    }
    fn take_failures(&mut self) -> Vec<f32> {
        let zeros = vec![0.0; self.failures.len()];
        std::mem::replace(&mut self.failures, zeros)
    }
    fn new_sampler(&self) -> SamplerState {
        SamplerState::uniform(self.library.len(), self.library.bins())
    }
    fn set_sampler(&mut self, sampler: &SamplerState) {
        assert_eq!(
            (sampler.motions, sampler.bins),
            (self.sampler.motions, self.sampler.bins),
            "sampler of another library"
        );
        self.sampler = sampler.clone();
    }
    fn set_ball_curriculum(&mut self, curriculum: BallCurriculum) {
        self.curriculum = curriculum;
    }
}

impl<V: Real, S: Simulator<V>> TaskShard for Task<V, S> {
    fn layout(&self) -> &ObservationLayout {
        &self.config.layout
    }
    fn eval(&mut self) -> &mut dyn EvalControl {
        self
    }
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// Moves the lanes' sums into the metrics.
    fn fold_sums(&mut self) {
        let sums = std::mem::replace(&mut self.sums, Sums::new(&self.config.preset));
        for lane in 0..V::LANES {
            for (total, sum) in self.metrics.reward_terms.iter_mut().zip(sums.terms.iter().chain(&sums.own)) {
                *total += sum.lane(lane);
            }
            for (total, sum) in self.metrics.tracking.iter_mut().zip(&sums.tracking) {
                *total += sum.lane(lane);
            }
        }
    }

    /// Place and heading of the reference's anchor in an environment's frame.
    fn reference_anchor(&self, env: &EnvTask) -> ([f64; 2], f64) {
        let clip = &self.library.clips()[env.motion];
        let bodies = clip.body_pos.len() / clip.frames;
        let frame = (env.frame - 1).min(clip.frames - 1);
        let row = frame * bodies + self.config.followed[self.config.anchor];
        let [x, y, _] = clip.body_pos[row];
        let heading = heading_of(clip.body_quat[row]);
        env.anchoring.map_or(([x, y], heading), |a| (a.point([x, y]), heading + a.turn))
    }

    fn env_index(&self, env: usize) -> Result<(usize, usize), TaskError> {
        if env < self.envs.len() {
            Ok((env / V::LANES, env % V::LANES))
        } else {
            Err(TaskError::Eval(format!("environment {env} of {}", self.envs.len())))
        }
    }
}

impl<V: Real, S: Simulator<V>> EvalControl for Task<V, S> {
    fn set_rules(&mut self, rules: EpisodeRules) {
        self.rules = rules;
        let keep = rules.reward_terms == RewardTermsInSamples::Kept;
        for group in &mut self.groups {
            group.terms = keep.then(|| vec![V::zero(); reward_names().len()]);
        }
        for env in &mut self.envs {
            env.ended = None;
            if rules == EpisodeRules::TRAINING {
                env.forced = None;
            }
        }
    }

    fn force_start(&mut self, env: usize, start: &InitialState) -> Result<(), TaskError> {
        let (group, lane) = self.env_index(env)?;
        let facts =
            self.library.facts().get(start.motion).ok_or_else(|| {
                TaskError::Eval(format!("motion {} of {}", start.motion, self.library.len()))
            })?;
        if start.frame + 1 >= facts.frames {
            return Err(TaskError::Eval(format!(
                "start frame {} of motion '{}' with {} frames",
                start.frame, facts.name, facts.frames
            )));
        }
        let places = [start.ball_xy.unwrap_or_default(), start.goal_xy.unwrap_or_default()];
        let numbers = places.iter().flatten().chain(&start.ball_velocity).chain(&start.displacement);
        if numbers.into_iter().any(|x| !x.is_finite()) {
            return Err(TaskError::Eval("a number of the start is not finite".into()));
        }
        self.envs[env].forced = Some(start.clone());
        self.reset_lanes(group, 1 << lane);
        self.gather(group);
        Ok(())
    }

    fn next_kick(&mut self, env: usize, next: &NextKick) -> Result<(), TaskError> {
        let (group, lane) = self.env_index(env)?;
        self.begin_next_kick(env, [group, lane], next)
    }

    fn show(&mut self, env: usize, shown: Option<&Shown>) -> Result<(), TaskError> {
        let (group, lane) = self.env_index(env)?;
        let of_group = &mut self.groups[group].shown;
        match shown {
            Some(shown) => of_group.get_or_insert_with(ShownScene::new).set_lane(lane, shown),
            None => {
                *of_group = None;
                Ok(())
            }
        }
    }

    fn disturb(&mut self, env: usize, disturbance: &Disturbance) -> Result<(), TaskError> {
        let (group, lane) = self.env_index(env)?;
        self.take(env, [group, lane], disturbance)
    }

    fn ball_spin(&self, env: usize) -> Result<[f64; 3], TaskError> {
        let (group, lane) = self.env_index(env)?;
        Ok(self.sim.state(group).ball.ang_vel.lane(lane))
    }

    fn believed_ball(&self, env: usize) -> Result<Option<BelievedBall>, TaskError> {
        let (group, lane) = self.env_index(env)?;
        let (state, task) = (self.sim.state(group), &self.groups[group]);
        let Some(eyes) = task.eyes.as_ref().filter(|_| task.shown.is_none()) else { return Ok(None) };
        Ok(Some(believed_ball(eyes, &self.config, state, task.to_strike_s, lane)))
    }

    fn sample(&self, env: usize) -> Result<EnvSample, TaskError> {
        let (group, lane) = self.env_index(env)?;
        let (state, task, info) = (self.sim.state(group), &self.groups[group], &self.envs[env]);
        let facts = &self.library.facts()[info.motion];
        let finite = |x: f64| if x.is_finite() { x } else { 0.0 };
        let terms = task.terms.iter().flatten();
        let numbers = |values: &[V]| values.iter().map(|v| v.lane(lane)).collect::<Vec<_>>();
        let bodies = state.bodies.iter().map(|b| BodySample {
            pos: b.pos.lane(lane),
            rot: b.rot.0.map(|row| row.map(|v| v.lane(lane))),
            com_vel: b.com_vel.lane(lane),
            ang_vel: b.ang_vel.lane(lane),
        });
        Ok(EnvSample {
            motion: info.motion,
            frame: (info.frame - 1).min(facts.frames - 1),
            step: info.step,
            motion_ended: self.config.has_reference && info.frame >= facts.frames,
            bodies: bodies.collect(),
            joint_pos: numbers(&state.joint_pos),
            joint_target: self.joint_target(task, lane),
            joint_vel: numbers(&state.joint_vel),
            joint_torque: numbers(&state.joint_torque),
            contact_force: state.contact_force.iter().map(|force| force.lane(lane)).collect(),
            ground_m: self.ground_below(group, lane),
            ball_pos: state.ball.pos.lane(lane),
            ball_vel: state.ball.vel.lane(lane),
            ball_force: state.ball.robot_force.lane(lane),
            goal_pos: task.goal.lane(lane),
            reference_anchor: self.reference_anchor(info),
            heading: facts.heading + info.anchoring.map_or(0.0, |a| a.turn),
            kick: info.kick.clone(),
            rewards: terms.map(|v| finite(v.lane(lane))).collect(),
        })
    }
}

impl<V: Real, S: Simulator<V>> Task<V, S> {
    /// Height of the ground below the base of a lane `[m]`.
    fn ground_below(&self, group: usize, lane: usize) -> f64 {
        let [x, y, _] = self.sim.state(group).bodies[0].pos.lane(lane);
        self.sim.ground_height(group, lane, [x, y])
    }

    /// Where the last action of a lane sends the joints, model order `[rad]`.
    fn joint_target(&self, task: &GroupTask<V>, lane: usize) -> Vec<f64> {
        let control = &self.config.control;
        let mut targets = vec![0.0; self.config.joints()];
        for (j, &m) in self.config.to_model.iter().enumerate() {
            let rest = control.default_pos[m] + task.joint_offset[m].lane(lane);
            targets[m] = joint_target(task.action[j].lane(lane), control.action_scale[m], rest);
        }
        targets
    }
}
