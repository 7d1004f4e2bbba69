//! A simulator that plays a reference back, and tasks over it.

use std::sync::Arc;

use paid_lanes::{Quat, Vec3};
use paid_physics::{EnvParams, GroupState, LaneState, LateTargets, Simulator};
use paid_play::{ReferenceClip, ReferenceLibrary};
use paid_policy::{StepBuffers, VecEnv};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{Task, TaskPreset, TaskSetup, TrainShard, reward_names};

pub const FRAMES: usize = 60;
pub const SPEED: f64 = 0.5;

/// A robot that slides along -y at constant speed in its default pose; the right foot is fastest at frame 40.
pub fn clip(robot: &RobotModel, spec: &RobotSpec, kick_foot: usize) -> ReferenceClip {
    let default = spec.resolve(robot).expect("fits").default_pos;
    let bodies = robot.bodies.len();
    let foot = robot.body_index(&spec.feet[kick_foot]).expect("a foot");
    let half = core::f64::consts::FRAC_1_SQRT_2;
    let mut clip = ReferenceClip {
        name: format!("slide{kick_foot}"),
        fps: 50.0,
        kick_foot,
        strike_frame: None,
        frames: FRAMES,
        joint_pos: Vec::new(),
        joint_vel: vec![0.0; FRAMES * robot.joints.len()],
        body_pos: Vec::new(),
        body_quat: vec![[half, 0.0, 0.0, -half]; FRAMES * bodies],
        body_com_vel: vec![[0.0, -SPEED, 0.0]; FRAMES * bodies],
        body_ang_vel: vec![[0.0; 3]; FRAMES * bodies],
    };
    for t in 0..FRAMES {
        clip.joint_pos.extend(&default);
        for (b, body) in robot.bodies.iter().enumerate() {
            let side = spec.feet.iter().position(|f| *f == body.name).map_or(0.0, |s| [0.2, -0.2][s]);
            clip.body_pos.push([side, -SPEED * 0.02 * t as f64, 0.8 - 0.02 * b as f64]);
        }
    }
    clip.body_com_vel[40 * bodies + foot] = [0.0, -5.0, 0.0];
    clip
}

/// Plays frame after frame from where a lane was reset to; at frame `kick_at` the right foot hits the ball.
pub struct Playback {
    pub robot: RobotModel,
    pub library: Arc<ReferenceLibrary>,
    pub foot_height: f64,
    pub aside: f64,
    pub motion: usize,
    pub frame: usize,
    pub kick_at: usize,
    pub ball: LaneState,
    pub pushes: Vec<(usize, [f64; 3], [f64; 3])>,
    pub steps: usize,
    pub params: EnvParams,
    pub state: GroupState<f64>,
}

impl Playback {
    pub fn new(robot: &RobotModel, library: &Arc<ReferenceLibrary>, kick_at: usize) -> Self {
        let joints = vec![0.0; robot.joints.len()];
        let lane = LaneState {
            base_pos: [0.0; 3],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            base_lin_vel: [0.0; 3],
            base_ang_vel: [0.0; 3],
            joint_pos: joints.clone(),
            joint_vel: joints,
            ball_pos: [0.0; 3],
            ball_vel: [0.0; 3],
            ball_ang_vel: [0.0; 3],
            warm_start: Vec::new(),
        };
        Self {
            robot: robot.clone(),
            library: Arc::clone(library),
            foot_height: 0.0,
            aside: 0.0,
            motion: 0,
            frame: 0,
            kick_at,
            ball: lane,
            pushes: Vec::new(),
            steps: 0,
            params: EnvParams::default(),
            state: GroupState::empty(robot.joints.len(), robot.bodies.len()),
        }
    }

    fn show(&mut self) {
        let clip = &self.library.clips()[self.motion];
        let t = self.frame.min(clip.frames - 1);
        let (bodies, joints) = (self.robot.bodies.len(), self.robot.joints.len());
        for (b, body) in self.state.bodies.iter_mut().enumerate() {
            let row = t * bodies + b;
            body.pos = Vec3(clip.body_pos[row]);
            body.pos.0[2] += self.foot_height;
            body.pos.0[0] += self.aside;
            body.rot = Quat(clip.body_quat[row]).to_mat();
            body.com_vel = Vec3(clip.body_com_vel[row]);
            body.lin_vel = body.com_vel;
            body.ang_vel = Vec3(clip.body_ang_vel[row]);
        }
        self.state.joint_pos.copy_from_slice(&clip.joint_pos[t * joints..][..joints]);
        self.state.joint_vel.copy_from_slice(&clip.joint_vel[t * joints..][..joints]);
        self.state.ball.pos = Vec3(self.ball.ball_pos);
        self.state.ball.vel = Vec3(self.ball.ball_vel);
        self.state.ball.ang_vel = Vec3(self.ball.ball_ang_vel);
    }
}

impl Simulator<f64> for Playback {
    fn model(&self) -> &RobotModel {
        &self.robot
    }
    fn groups(&self) -> usize {
        1
    }
    fn control_dt_s(&self) -> f64 {
        0.02
    }
    fn step_late(&mut self, _: usize, _: LateTargets<'_, f64>) {
        self.frame += 1;
        self.steps += 1;
        let kicks = self.frame == self.kick_at;
        self.state.ball.robot_force = Vec3([if kicks { 100.0 } else { 0.0 }, 0.0, 0.0]);
        if kicks {
            self.ball.ball_vel = [0.0, -4.0, 1.0];
            // The right foot stands next to the ball, the left one farther away.
            self.ball.ball_pos[0] = -0.2;
        }
        for k in 0..3 {
            self.ball.ball_pos[k] += 0.02 * self.ball.ball_vel[k];
        }
        self.show();
    }
    fn state(&self, _: usize) -> &GroupState<f64> {
        &self.state
    }
    fn reset_lane(&mut self, _: usize, _: usize, state: &LaneState) {
        self.ball = state.clone();
        // The frame follows from the place along the way; noise is off in these tests.
        self.frame = (-state.base_pos[1] / (SPEED * 0.02)).round() as usize;
        self.state.ball.robot_force = Vec3::zero();
    }
    fn refresh(&mut self, _: usize) {
        self.show();
    }
    fn save_lane(&self, _: usize, _: usize) -> LaneState {
        self.ball.clone()
    }
    fn set_params(&mut self, _: usize, _: usize, params: &EnvParams) {
        self.params = params.clone();
    }
    fn push_lane(&mut self, _: usize, _: usize, linear: [f64; 3], angular: [f64; 3]) {
        self.pushes.push((self.steps, linear, angular));
    }
    fn set_ball(&mut self, _: usize, _: usize, pos: [f64; 3], vel: [f64; 3], ang_vel: [f64; 3]) {
        (self.ball.ball_pos, self.ball.ball_vel, self.ball.ball_ang_vel) = (pos, vel, ang_vel);
        self.show();
    }
    fn ground_height(&self, _: usize, _: usize, _: [f64; 2]) -> f64 {
        0.0
    }
}

/// `TaskPreset` without noise, randomness of the start or pushes.
pub fn preset(name: &str, more: &[&str]) -> TaskPreset {
    let quiet = [
        "resets.xy_m=0",
        "resets.z_m=0",
        "resets.roll_pitch_rad=0",
        "resets.yaw_rad=0",
        "resets.velocity={xy=0, z=0, roll_pitch=0, yaw=0}",
        "resets.joint_rad=0",
        "pushes.enabled=false",
        "ball.angle_deg=0",
        "ball.radius_m=0",
        "ball.rolling_share=0",
        "ball.clearance_m=0",
        "sampling.first_frame_share=1",
        "rewards.body_kernel=exp_of_mean",
        "rewards.ball_prox.from=anchor",
    ];
    let overrides: Vec<String> = quiet.iter().chain(more).map(|s| (*s).to_owned()).collect();
    TaskPreset::builtin_with(&format!("paper_{name}"), &overrides).expect("valid")
}

pub fn task(name: &str, more: &[&str], kick_foot: usize, kick_at: usize) -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    playback(clip(&robot, &spec, kick_foot), &preset(name, more), kick_at, |_| ())
}

/// A task whose simulator plays back `clip`, after `change` of the simulator.
pub fn playback(
    clip: ReferenceClip,
    preset: &TaskPreset,
    kick_at: usize,
    change: impl FnOnce(&mut Playback),
) -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let library = Arc::new(ReferenceLibrary::new(vec![clip], &robot, &spec).expect("fits"));
    let mut sim = Playback::new(&robot, &library, kick_at);
    change(&mut sim);
    let setup = TaskSetup { robot: &robot, spec: &spec, library: &library, preset, first_env: 0, seed: 1 };
    Task::new(sim, &setup).expect("fits")
}

/// Steps with zero actions: rewards and (terminated, truncated) of each step.
pub fn steps(task: &mut Task<f64, Playback>, n: usize) -> Vec<(f32, u8, u8)> {
    let actions = vec![0.0; task.action_dim()];
    (0..n)
        .map(|_| {
            let (mut reward, mut terminated, mut truncated) = ([0.0], [0], [0]);
            task.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
            (reward[0], terminated[0], truncated[0])
        })
        .collect()
}

pub fn term(task: &mut Task<f64, Playback>, name: &str) -> f64 {
    task.take_metrics().reward_terms[reward_names().iter().position(|n| *n == name).expect("a term")]
}

pub fn playback_with_height(height: f64) -> Task<f64, Playback> {
    let clip = clip(&RobotModel::g1(), &RobotSpec::g1(), 1);
    playback(clip, &preset("stage1", &[]), usize::MAX, |sim| sim.foot_height = height)
}
