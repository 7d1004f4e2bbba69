//! One robot, one ball, one policy in one engine, on a pitch that stays where it is when the robot is put elsewhere.

use std::time::{Duration, Instant};

use paid_eval::episodes::EvalSetup;
use paid_eval::policy::{Driver, DriverInput};
use paid_eval::subject::Subject;
use paid_lanes::{Mat3, Quat, Vec3};
use paid_policy::StepBuffers;
use paid_task::{
    BelievedBall, Disturbance, EnvSample, EpisodeRules, EvalControl, InitialState, NextKick,
    RewardTermsInSamples, TaskShard, TimeLimit,
};

use crate::drawn::Drawn;
use crate::{LiveError, Pose2};

/// A kick as the visitor sees it, in the pitch's axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct KickPlan {
    /// Number of the clip.
    pub motion: usize,
    /// Ball center (x, y) `[m]`.
    pub ball: [f64; 2],
    /// Ball velocity `[m/s]`.
    pub velocity: [f64; 2],
    /// Goal center (x, y) `[m]`.
    pub goal: [f64; 2],
    /// Number of the look at the ball.
    pub look: u64,
    /// Where the robot takes its first pose; `None`: it continues from its present pose.
    pub stance: Option<Pose2>,
}

/// The engine and who acts in it. Lanes beyond the first repeat it.
pub(crate) struct Arena {
    setup: EvalSetup,
    shard: Box<dyn TaskShard>,
    driver: Box<dyn Driver>,
    envs: usize,
    /// Model index of the body that anchors the reference.
    anchor: usize,
    observations: Vec<f32>,
    critic: Vec<f32>,
    actions: Vec<f32>,
    reward: Vec<f32>,
    ended: [Vec<u8>; 2],
    sample: EnvSample,
    believed: Option<BelievedBall>,
    /// The world's axes on the pitch.
    axes: Pose2,
    ball_quat: Quat<f64>,
    /// Time of the last control step.
    pub cost: Duration,
}

/// In double precision.
pub(crate) fn array(v: [f32; 2]) -> [f64; 2] {
    v.map(f64::from)
}

impl Arena {
    /// The subject in the setup's engine; the robot stands at the pitch's origin.
    pub fn new(subject: &Subject, setup: EvalSetup) -> Result<Self, LiveError> {
        let envs = setup.lanes();
        let mut shard = setup.build(envs, 0)?;
        let driver = (subject.maker)()?;
        shard.eval().set_rules(EpisodeRules {
            time_limit: TimeLimit::Steps(u32::MAX),
            reward_terms: RewardTermsInSamples::Kept,
            ..EpisodeRules::evaluation()
        });
        let sample = shard.eval().sample(0)?;
        let mut arena = Self {
            anchor: setup.robot.body_index(&setup.spec.anchor_body).unwrap_or(0),
            observations: vec![0.0; shard.policy_obs_dim() * envs],
            critic: vec![0.0; shard.critic_obs_dim() * envs],
            actions: vec![0.0; shard.action_dim() * envs],
            reward: vec![0.0; envs],
            ended: [vec![0; envs], vec![0; envs]],
            axes: Pose2::default(),
            ball_quat: Quat::identity(),
            cost: Duration::ZERO,
            setup,
            shard,
            driver,
            envs,
            sample,
            believed: None,
        };
        arena.stand(&Pose2::default(), [1.0, 0.0], [5.0, 0.0])?;
        Ok(arena)
    }

    pub fn setup(&self) -> &EvalSetup {
        &self.setup
    }

    /// The state after the last step or meddling, world axes.
    pub fn sample(&self) -> &EnvSample {
        &self.sample
    }

    /// The same in every lane.
    fn each(
        &mut self,
        act: impl Fn(&mut dyn EvalControl, usize) -> Result<(), paid_task::TaskError>,
    ) -> Result<(), LiveError> {
        let control = self.shard.eval();
        for env in 0..self.envs {
            act(control, env)?;
        }
        self.sample = control.sample(0)?;
        self.believed = control.believed_ball(0)?;
        Ok(())
    }

    /// The robot holds a clip's last pose with its anchor at `pose` of the pitch; ball and goal lie at these places.
    pub fn stand(&mut self, pose: &Pose2, ball: [f64; 2], goal: [f64; 2]) -> Result<(), LiveError> {
        let frames = self.setup.library.facts()[0].frames;
        let start = InitialState { frame: frames.saturating_sub(2), ..InitialState::nominal(0) };
        self.each(|control, env| control.force_start(env, &start))?;
        self.driver.begin(self.envs);
        self.axes = pose.over(&self.anchor_in_world());
        self.put_ball(ball, [0.0; 2])?;
        self.put_goal(goal)
    }

    /// A kick begins.
    pub fn kick(&mut self, plan: &KickPlan) -> Result<(), LiveError> {
        let from = plan.stance.unwrap_or_else(|| self.anchor());
        let ball_xy = from.local(plan.ball);
        let goal_xy = from.local(plan.goal);
        let ball_velocity = crate::pose2::turned(plan.velocity, -from.heading);
        if plan.stance.is_some() {
            let start = InitialState {
                ball_xy: Some(ball_xy),
                ball_velocity,
                goal_xy: Some(goal_xy),
                ..InitialState::nominal(plan.motion)
            };
            self.each(|control, env| control.force_start(env, &start))?;
            self.driver.begin(self.envs);
            let facts = &self.setup.library.facts()[plan.motion];
            self.axes = from.over(&Pose2 { xy: facts.start_xy, heading: facts.heading });
            return Ok(());
        }
        let next = NextKick { motion: plan.motion, ball_xy, ball_velocity, goal_xy, look: plan.look };
        self.each(|control, env| control.next_kick(env, &next))?;
        (0..self.envs).for_each(|env| self.driver.forget(env));
        Ok(())
    }

    /// Replaces the policy by another one of the same shape.
    pub fn act_by(&mut self, mut driver: Box<dyn Driver>) {
        driver.begin(self.envs);
        self.driver = driver;
    }

    /// The robot follows a clip from its first frame, with its anchor at the pitch's origin.
    pub fn follow(&mut self, motion: usize) -> Result<(), LiveError> {
        self.each(|control, env| control.force_start(env, &InitialState::nominal(motion)))?;
        self.driver.begin(self.envs);
        self.axes = Pose2::default().over(&self.anchor_in_world());
        Ok(())
    }

    fn has_ball(&self) -> bool {
        self.setup.preset.scene.ball
    }

    /// The ball lies or rolls at a place of the pitch `[m]`, `[m/s]`; nothing happens where there is none.
    pub fn put_ball(&mut self, at: [f64; 2], velocity: [f64; 2]) -> Result<(), LiveError> {
        if !self.has_ball() {
            return Ok(());
        }
        let [x, y] = self.axes.local(at);
        let [vx, vy] = crate::pose2::turned(velocity, -self.axes.heading);
        let ball = Disturbance::Ball { pos: [x, y, self.ball_radius_m()], vel: [vx, vy, 0.0] };
        self.each(|control, env| control.disturb(env, &ball))
    }

    /// The ball continues with another velocity `[m/s]`, pitch axes.
    pub fn set_ball_velocity(&mut self, [vx, vy, vz]: [f64; 3]) -> Result<(), LiveError> {
        let [vx, vy] = crate::pose2::turned([vx, vy], -self.axes.heading);
        let ball = Disturbance::Ball { pos: self.sample.ball_pos, vel: [vx, vy, vz] };
        self.each(|control, env| control.disturb(env, &ball))
    }

    /// The goal's middle is at a place of the pitch `[m]`.
    pub fn put_goal(&mut self, at: [f64; 2]) -> Result<(), LiveError> {
        if !self.has_ball() {
            return Ok(());
        }
        let goal = Disturbance::Goal(self.axes.local(at));
        self.each(|control, env| control.disturb(env, &goal))
    }

    /// An impulse on the robot `[N s]`, pitch axes.
    pub fn push(&mut self, impulse: [f32; 2]) -> Result<(), LiveError> {
        let [x, y] = crate::pose2::turned(array(impulse), -self.axes.heading);
        self.each(|control, env| control.disturb(env, &Disturbance::Push([x, y, 0.0])))
    }

    /// One control step.
    pub fn step(&mut self) -> Result<(), LiveError> {
        let start = Instant::now();
        self.shard.observe(&mut [&mut self.observations, &mut self.critic]);
        let seen =
            DriverInput { observations: &self.observations, envs: self.envs, world: self.shard.eval() };
        self.driver.act(seen, &mut self.actions)?;
        if let Some(i) = self.actions.iter().position(|a| !a.is_finite()) {
            return Err(LiveError::Action { joint: i / self.envs, value: self.actions[i] });
        }
        let [terminated, truncated] = &mut self.ended;
        self.shard.step(&self.actions, StepBuffers::new(&mut self.reward, terminated, truncated));
        let control = self.shard.eval();
        self.sample = control.sample(0)?;
        self.believed = control.believed_ball(0)?;
        let spin = Vec3(control.ball_spin(0)?);
        self.ball_quat = self.ball_quat.integrate(spin, self.setup.preset.control_dt_s());
        self.cost = start.elapsed();
        Ok(())
    }

    pub fn ball_radius_m(&self) -> f64 {
        self.setup.preset.ball_params.radius_m
    }

    fn anchor_in_world(&self) -> Pose2 {
        let body = &self.sample.bodies[self.anchor];
        Pose2 { xy: [body.pos[0], body.pos[1]], heading: Mat3(body.rot).yaw() }
    }

    /// The robot's anchor on the pitch.
    pub fn anchor(&self) -> Pose2 {
        self.axes.pose(&self.anchor_in_world())
    }

    /// True if a ball at `ball`, from the robot's anchor, would touch the robot in its present pose.
    pub fn touches(&self, ball: [f64; 2]) -> bool {
        paid_eval::shooting::Placement::new(&self.setup).touches(&self.sample, self.anchor, ball)
    }

    /// The ball's center on the pitch `[m]`.
    pub fn ball(&self) -> [f64; 3] {
        self.drawn().place(self.sample.ball_pos)
    }

    /// The state as the page draws it.
    pub fn drawn(&self) -> Drawn<'_> {
        Drawn {
            axes: self.axes,
            sample: &self.sample,
            ball_quat: self.ball_quat,
            believed: self.believed,
            library: &self.setup.library,
            anchor: self.anchor,
        }
    }
}
