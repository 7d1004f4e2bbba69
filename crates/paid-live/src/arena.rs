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

use crate::wire::{Belief, Body, Force};
use crate::{LiveError, Pose2};

/// Contact forces below this are not shown `[N]`.
const LEAST_FORCE_N: f64 = 5.0;

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
    /// Where the robot takes its first pose; `None`: it goes on as it stands.
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
        self.each(|control, env| control.next_kick(env, &next))
    }

    /// Another policy of the same shape acts from now on.
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

    /// The ball goes on with another velocity `[m/s]`, pitch axes.
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
        let angle = spin.norm() * self.setup.preset.control_dt_s();
        if angle > 1e-9 {
            let axis = spin.scale(1.0 / spin.norm());
            self.ball_quat = Quat::from_axis_angle(axis, angle).mul(self.ball_quat).normalize();
        }
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

    /// True if a ball at `ball`, from the robot's anchor, would touch the robot as it stands.
    pub fn touches(&self, ball: [f64; 2]) -> bool {
        paid_eval::shooting::Placement::new(&self.setup).touches(&self.sample, self.anchor, ball)
    }

    /// A point of the world on the pitch `[m]`.
    fn place(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = self.axes.point([x, y]);
        [x, y, z]
    }

    /// A vector of the world in the pitch's axes.
    pub fn vector(&self, [x, y, z]: [f64; 3]) -> [f64; 3] {
        let [x, y] = crate::pose2::turned([x, y], self.axes.heading);
        [x, y, z]
    }

    /// The ball.
    pub fn ball(&self) -> Body {
        let yaw: Quat<f64> = Quat::from_roll_pitch_yaw(0.0, 0.0, self.axes.heading);
        Body { pos: self.place(self.sample.ball_pos), quat: yaw.mul(self.ball_quat).0 }
    }

    /// Where the robot believes the ball to be, and whether the ball is in its picture.
    pub fn belief(&self) -> (Option<Belief>, bool) {
        let belief = self.believed.map(|ball| Belief {
            pos: self.place(ball.pos).map(|x| x as f32),
            deviation_m: ball.deviation_m as f32,
            age_s: ball.age_s as f32,
        });
        (belief, self.believed.is_some_and(|ball| ball.in_view))
    }

    /// The robot, model order.
    pub fn bodies(&self) -> Vec<Body> {
        let yaw: Quat<f64> = Quat::from_roll_pitch_yaw(0.0, 0.0, self.axes.heading);
        let body = |b: &paid_task::BodySample| Body {
            pos: self.place(b.pos),
            quat: yaw.mul(Mat3(b.rot).to_quat()).0,
        };
        self.sample.bodies.iter().map(body).collect()
    }

    /// The reference, model order.
    pub fn ghost(&self) -> Vec<Body> {
        let (sample, clip) = (&self.sample, &self.setup.library.clips()[self.sample.motion]);
        let count = sample.bodies.len();
        let rows = sample.frame * count..(sample.frame + 1) * count;
        let (pos, quat) = (&clip.body_pos[rows.clone()], &clip.body_quat[rows]);
        let anchor_rot: Mat3<f64> = Quat(quat[self.anchor]).to_mat();
        let [x, y, _] = pos[self.anchor];
        let in_clip = Pose2 { xy: [x, y], heading: anchor_rot.yaw() };
        let (xy, heading) = sample.reference_anchor;
        let axes = self.axes.pose(&Pose2 { xy, heading }.over(&in_clip));
        let yaw: Quat<f64> = Quat::from_roll_pitch_yaw(0.0, 0.0, axes.heading);
        let body = |([x, y, z], q): ([f64; 3], [f64; 4])| {
            let [x, y] = axes.point([x, y]);
            Body { pos: [x, y, z], quat: yaw.mul(Quat(q)).0 }
        };
        pos.iter().copied().zip(quat.iter().copied()).map(body).collect()
    }

    /// Contact forces that can be seen.
    pub fn forces(&self) -> Vec<Force> {
        let bodies = self.sample.contact_force.iter().enumerate();
        let mut forces: Vec<Force> = bodies
            .filter(|(_, f)| Vec3(**f).norm() >= LEAST_FORCE_N)
            .filter_map(|(i, f)| Some(Force { body: Some(u8::try_from(i).ok()?), newton: self.vector(*f) }))
            .collect();
        if Vec3(self.sample.ball_force).norm() >= LEAST_FORCE_N {
            forces.push(Force { body: None, newton: self.vector(self.sample.ball_force) });
        }
        forces
    }
}
