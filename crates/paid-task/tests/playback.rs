//! The task over a simulator that plays the reference back: what a perfect robot is paid, and how episodes end.

use std::sync::Arc;

use paid_lanes::{Quat, Vec3};
use paid_physics::{BallState, BodyState, EnvParams, GroupState, LaneState, Simulator};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    EndCause, EvalControl, EvalOptions, ForcedStart, REWARD_NAMES, ReferenceClip, ReferenceLibrary, Task,
    TaskPreset, TaskShard,
};

const FRAMES: usize = 60;
const SPEED: f64 = 0.5;

/// A robot that slides along -y at constant speed in its default pose; the right foot is fastest at frame 40.
fn clip(robot: &RobotModel, spec: &RobotSpec, kick_foot: usize) -> ReferenceClip {
    let default = spec.resolve(robot).expect("fits").default_pos;
    let bodies = robot.bodies.len();
    let foot = robot.body_index(&spec.feet[kick_foot]).expect("a foot");
    let half = core::f64::consts::FRAC_1_SQRT_2;
    let mut clip = ReferenceClip {
        name: format!("slide{kick_foot}"),
        fps: 50.0,
        kick_foot,
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
struct Playback {
    robot: RobotModel,
    library: Arc<ReferenceLibrary>,
    foot_height: f64,
    aside: f64,
    motion: usize,
    frame: usize,
    kick_at: usize,
    ball: LaneState,
    pushes: Vec<(usize, [f64; 3], [f64; 3])>,
    steps: usize,
    params: EnvParams,
    state: GroupState<f64>,
}

impl Playback {
    fn new(robot: &RobotModel, library: &Arc<ReferenceLibrary>, kick_at: usize) -> Self {
        let zero = Vec3([0.0; 3]);
        let body = BodyState {
            pos: zero,
            rot: Quat([1.0, 0.0, 0.0, 0.0]).to_mat(),
            lin_vel: zero,
            com_vel: zero,
            ang_vel: zero,
        };
        let joints = vec![0.0; robot.joints.len()];
        let ball = BallState {
            pos: zero,
            vel: zero,
            ang_vel: zero,
            robot_force: Vec3::zero(),
            ground_force: Vec3::zero(),
            touched_by: -1.0,
        };
        let lane = LaneState {
            base_pos: [0.0; 3],
            base_quat: [1.0, 0.0, 0.0, 0.0],
            base_lin_vel: [0.0; 3],
            base_ang_vel: [0.0; 3],
            joint_pos: joints.clone(),
            joint_vel: joints.clone(),
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
            state: GroupState {
                joint_pos: joints.clone(),
                joint_vel: joints.clone(),
                joint_torque: joints,
                bodies: vec![body; robot.bodies.len()],
                contact_force: vec![Vec3::zero(); robot.bodies.len()],
                ball,
            },
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
    fn step(&mut self, _: usize, _: &[f64]) {
        self.frame += 1;
        self.steps += 1;
        let kicks = self.frame == self.kick_at;
        self.state.ball.robot_force = Vec3([if kicks { 100.0 } else { 0.0 }, 0.0, 0.0]);
        if kicks {
            self.ball.ball_vel = [0.0, -4.0, 1.0];
            // The right foot stands beside the ball, the left one farther away.
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
    fn ground_height(&self, _: usize, _: usize, _: [f64; 2]) -> f64 {
        0.0
    }
}

/// `TaskPreset` without noise, randomness of the start or pushes.
fn preset(name: &str, more: &[&str]) -> TaskPreset {
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
    ];
    let text = paid_task::preset::BUILTIN.iter().find(|(n, _)| *n == name).expect("built in").1;
    let overrides: Vec<String> = quiet.iter().chain(more).map(|s| (*s).to_owned()).collect();
    TaskPreset::parse(name, text, &overrides).expect("valid")
}

fn task(name: &str, more: &[&str], kick_foot: usize, kick_at: usize) -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let library = ReferenceLibrary::new(vec![clip(&robot, &spec, kick_foot)], &robot, &spec).expect("fits");
    let library = Arc::new(library);
    let sim = Playback::new(&robot, &library, kick_at);
    Task::new(sim, &robot, &spec, &library, &preset(name, more), 0, 1).expect("fits")
}

/// Steps with zero actions: rewards and (terminated, truncated) of each step.
fn steps(task: &mut Task<f64, Playback>, n: usize) -> Vec<(f32, u8, u8)> {
    let actions = vec![0.0; task.action_dim()];
    (0..n)
        .map(|_| {
            let (mut reward, mut terminated, mut truncated) = ([0.0], [0], [0]);
            task.step(&actions, &mut reward, &mut terminated, &mut truncated);
            (reward[0], terminated[0], truncated[0])
        })
        .collect()
}

fn term(task: &mut Task<f64, Playback>, name: &str) -> f64 {
    task.take_metrics().reward_terms[REWARD_NAMES.iter().position(|n| *n == name).expect("a term")]
}

#[test]
fn perfect_tracking_earns_every_weight_until_the_motion_ends() {
    let mut task = task("stage1", &[], 1, usize::MAX);
    let results = steps(&mut task, FRAMES - 1);
    for (step, (reward, terminated, truncated)) in results.iter().enumerate() {
        // Six tracking terms of weight 1, times 0.02 s.
        assert!((reward - 0.12).abs() < 1e-6, "{step}: {reward}");
        assert_eq!((*terminated, *truncated), (0, u8::from(step == FRAMES - 2)), "{step}");
    }
    let metrics = task.take_metrics();
    assert_eq!(
        (metrics.episodes, metrics.ends[EndCause::MotionEnd as usize], metrics.episode_steps),
        (1, 1, 59)
    );
    assert!(
        (metrics.kick_foot_peak_sum - 5.0).abs() < 1e-5
            && (metrics.reference_foot_peak_sum - 5.0).abs() < 1e-5
    );
    assert!(task.take_failures().iter().all(|f| *f == 0.0));
}

#[test]
fn a_lift_of_the_whole_robot_fails_by_anchor_height_and_is_counted() {
    let mut broken = playback_with_height(0.3);
    assert_eq!(steps(&mut broken, 1)[0], (broken_reward(), 1, 0));
    let metrics = broken.take_metrics();
    assert_eq!(metrics.ends[0], 1);
    let failures = broken.take_failures();
    assert_eq!((failures.len(), failures[0]), (2, 1.0));
}

#[test]
fn a_robot_that_stays_behind_fails_by_anchor_distance_only_where_the_preset_asks() {
    for (limit, ends) in [("0.0", 0), ("0.5", 1)] {
        let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
        let library = ReferenceLibrary::new(vec![clip(&robot, &spec, 1)], &robot, &spec).expect("fits");
        let library = Arc::new(library);
        let sim = Playback { aside: 0.6, ..Playback::new(&robot, &library, usize::MAX) };
        let set = format!("terminations.anchor_distance_m={limit}");
        let preset = preset("stage1", &[&set]);
        let mut task = Task::new(sim, &robot, &spec, &library, &preset, 0, 1).expect("fits");
        assert_eq!(steps(&mut task, 1)[0].1, ends);
        assert_eq!(task.take_metrics().ends[EndCause::AnchorDistance as usize], u64::from(ends));
    }
}

fn playback_with_height(height: f64) -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let library = ReferenceLibrary::new(vec![clip(&robot, &spec, 1)], &robot, &spec).expect("fits");
    let library = Arc::new(library);
    let mut sim = Playback::new(&robot, &library, usize::MAX);
    sim.foot_height = height;
    Task::new(sim, &robot, &spec, &library, &preset("stage1", &[]), 0, 1).expect("fits")
}

/// A robot 0.3 m too high: anchor position exp(-1), body positions exp(-1), the other four terms 1.
fn broken_reward() -> f32 {
    (0.02 * (4.0 + 2.0 * (-1.0_f64).exp())) as f32
}

#[test]
fn a_kick_with_the_labelled_foot_pays_contact_swing_and_outcome() {
    let mut right = task("stage2", &[], 1, 40);
    steps(&mut right, 39);
    right.take_metrics();
    steps(&mut right, 1);
    let metrics = right.take_metrics();
    let value =
        |name: &str| metrics.reward_terms[REWARD_NAMES.iter().position(|n| *n == name).expect("a term")];
    assert!((value("contact") - 1.0).abs() < 1e-12);
    // The foot's velocity is along its x axis: no side kick.
    assert!(value("side_kick").abs() < 1e-9);
    assert!((value("speed") - 10.0 * 0.02 * (1.0 - (-16.0_f64 / 1.44).exp())).abs() < 1e-9);
    assert!((value("z_speed") + 0.2 * 0.02 * (1.0_f64 / 3.0).tanh()).abs() < 1e-9);
    assert!(value("vel_align") > 0.5 * 30.0 * 0.02);
    steps(&mut right, 10);
    let later = right.take_metrics();
    let value =
        |name: &str| later.reward_terms[REWARD_NAMES.iter().position(|n| *n == name).expect("a term")];
    assert_eq!(value("contact"), 0.0);
    // Four more steps of the window.
    assert!((value("speed") - 4.0 * 10.0 * 0.02 * (1.0 - (-16.0_f64 / 1.44).exp())).abs() < 1e-9);
    let kick = right.sample(0).expect("exists").kick.expect("a kick");
    assert_eq!(
        (kick.step, kick.foot, kick.correct, kick.ball_vel_after),
        (40, 1, true, Some([0.0, -4.0, 1.0]))
    );
    steps(&mut right, 9);
    let end = right.take_metrics();
    assert_eq!((end.kick.contacts, end.kick.correct_foot, end.kick.on_target), (1, 1, 1));
    assert!((end.kick.ball_speed_sum - 4.0).abs() < 1e-9);
}

#[test]
fn a_touch_long_before_the_strike_pays_nothing() {
    // The reference strikes in frame 40; 0.2 s are ten frames.
    for (kick_at, pays) in [(29, 0), (30, 1), (40, 1)] {
        let mut early = task("stage2", &["rewards.kick.early_s=0.2"], 1, kick_at);
        steps(&mut early, FRAMES - 1);
        let kick = early.take_metrics().kick;
        assert_eq!((kick.contacts, kick.correct_foot), (1, pays), "{kick_at}");
    }
}

#[test]
fn a_kick_with_the_other_foot_pays_nothing() {
    let mut left = task("stage2", &[], 0, 40);
    steps(&mut left, 50);
    let metrics = left.take_metrics();
    for name in ["contact", "side_kick", "vel_align", "speed"] {
        let index = REWARD_NAMES.iter().position(|n| *n == name).expect("a term");
        assert_eq!(metrics.reward_terms[index], 0.0, "{name}");
    }
    assert!(!left.sample(0).expect("exists").kick.expect("a kick").correct);
}

#[test]
fn proximity_is_frozen_at_the_first_contact() {
    let mut task = task("stage2", &[], 1, 20);
    steps(&mut task, 19);
    task.take_metrics();
    steps(&mut task, 1);
    let frozen = term(&mut task, "ball_prox");
    steps(&mut task, 10);
    assert!((term(&mut task, "ball_prox") - 10.0 * frozen).abs() < 1e-9);
}

#[test]
fn a_state_that_is_not_finite_ends_the_episode_and_nothing_else() {
    let mut task = playback_with_height(f64::NAN);
    let (reward, terminated, truncated) = steps(&mut task, 1)[0];
    assert_eq!((reward, terminated, truncated), (0.0, 1, 0));
    let metrics = task.take_metrics();
    assert_eq!(metrics.ends[EndCause::NotFinite as usize], 1);
    assert!(metrics.reward_terms.iter().chain(&metrics.tracking).all(|x| *x == 0.0));
}

#[test]
fn an_evaluation_holds_the_last_frame_and_obeys_the_forced_start() {
    let mut task = task("stage2", &["sampling.first_frame_share=0"], 1, usize::MAX);
    task.eval().set_eval(Some(EvalOptions { max_steps: Some(80), ..EvalOptions::default() }));
    let start = ForcedStart {
        ball_xy: Some([1.0, 0.25]),
        ball_velocity: [0.1, 0.2],
        goal_xy: Some([5.0, -1.0]),
        ..ForcedStart::nominal(0)
    };
    task.eval().force_start(0, &start).expect("exists");
    let sample = task.sample(0).expect("exists");
    // The motion faces -y: one metre ahead is at y = -1, left is +x.
    let near = |a: [f64; 3], b: [f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-9);
    assert!(near(sample.ball_pos, [0.25, -1.0, 0.11]), "{:?}", sample.ball_pos);
    assert!(near(sample.ball_vel, [0.2, -0.1, 0.0]), "{:?}", sample.ball_vel);
    assert!(near(sample.goal_pos, [-1.0, -5.0, 0.11]), "{:?}", sample.goal_pos);
    let results = steps(&mut task, 79);
    assert!(results.iter().all(|r| (r.1, r.2) == (0, 0)));
    let sample = task.sample(0).expect("exists");
    assert_eq!((sample.frame, sample.step, sample.motion_ended), (FRAMES - 1, 79, true));
    // The end is reported from then on, without a reset.
    assert!(steps(&mut task, 3).iter().all(|r| (r.1, r.2) == (0, 1)));
    assert_eq!(task.sample(0).expect("exists").step, 82);
    assert!(task.eval().force_start(0, &ForcedStart::nominal(1)).is_err());
    assert!(task.eval().force_start(1, &ForcedStart::nominal(0)).is_err());
}

#[test]
fn the_reward_terms_of_a_sample_add_up_to_the_reward_and_are_there_only_if_asked_for() {
    let mut task = task("stage2", &[], 1, 20);
    for reward_terms in [true, false] {
        task.eval().set_eval(Some(EvalOptions { reward_terms, ..EvalOptions::default() }));
        task.eval().force_start(0, &ForcedStart::nominal(0)).expect("exists");
        for _ in 0..25 {
            let (reward, ..) = steps(&mut task, 1)[0];
            let terms = task.sample(0).expect("exists").rewards;
            if reward_terms {
                assert_eq!(terms.len(), REWARD_NAMES.len());
                let sum: f64 = terms.iter().sum();
                assert!(reward != 0.0 && (sum - f64::from(reward)).abs() < 1e-5, "{sum} of {reward}");
            } else {
                assert!(terms.is_empty());
            }
        }
    }
}

#[test]
fn observations_are_placed_as_the_layout_says() {
    let mut task = task("stage1", &[], 1, usize::MAX);
    task.eval().set_eval(Some(EvalOptions::default()));
    task.eval().force_start(0, &ForcedStart::nominal(0)).expect("exists");
    let actions: Vec<f32> = (0..task.action_dim()).map(|j| 0.01 * j as f32).collect();
    task.step(&actions, &mut [0.0], &mut [0], &mut [0]);
    let mut policy = vec![9.0; task.policy_obs_dim()];
    let mut critic = vec![9.0; task.critic_obs_dim()];
    task.observe(&mut policy, &mut critic);
    let layout = task.layout().clone();
    let slice = |name: &str| {
        let term = layout.policy.iter().find(|t| t.name == name).expect("a term");
        policy[term.offset..term.offset + term.size].to_vec()
    };
    assert_eq!(slice("last_action"), actions);
    assert_eq!(slice("projected_gravity"), [0.0, 0.0, -1.0]);
    assert!(slice("joint_pos_rel").iter().all(|x| x.abs() < 1e-6));
    let spec = RobotSpec::g1();
    let robot = RobotModel::g1();
    let default = spec.resolve(&robot).expect("fits").default_pos;
    for (x, name) in slice("reference_joint_pos").iter().zip(&spec.policy_joint_order) {
        let expected = default[robot.joint_index(name).expect("a joint")];
        assert!((f64::from(*x) - expected).abs() < 1e-6, "{name}");
    }
    // The goal: 5 m ahead of the first frame, 0.01 m walked since, base 0.8 m and goal 0.11 m high.
    let goal = slice("goal_pos");
    assert!(
        (goal[0] - 4.99).abs() < 1e-5 && goal[1].abs() < 1e-5 && (goal[2] + 0.69).abs() < 1e-5,
        "{goal:?}"
    );
    let base_vel = layout.critic.iter().find(|t| t.name == "base_lin_vel").expect("a term").offset;
    assert!((critic[base_vel] - SPEED as f32).abs() < 1e-6);
}

/// A task with the preset's own noise whose episodes last one step.
fn restless(name: &str, more: &[&str]) -> Task<f64, Playback> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let library = ReferenceLibrary::new(vec![clip(&robot, &spec, 1)], &robot, &spec).expect("fits");
    let library = Arc::new(library);
    let sim = Playback::new(&robot, &library, usize::MAX);
    let text = paid_task::preset::BUILTIN.iter().find(|(n, _)| *n == name).expect("built in").1;
    let overrides: Vec<String> = more.iter().map(|s| (*s).to_owned()).collect();
    let preset = TaskPreset::parse(name, text, &overrides).expect("valid");
    let mut task = Task::new(sim, &robot, &spec, &library, &preset, 0, 1).expect("fits");
    let options =
        EvalOptions { max_steps: Some(1), auto_reset: true, disturbances: true, ..EvalOptions::default() };
    task.eval().set_eval(Some(options));
    task
}

#[test]
fn starts_are_the_references_plus_the_presets_noise() {
    let mut task = restless("stage2", &["sampling.first_frame_share=1", "randomisation.robot=true"]);
    let com = RobotModel::g1().bodies[0].com;
    assert!(com.iter().any(|x| *x != 0.0));
    let (mut widest, mut rolling, mut friction) = ([0.0_f64; 4], 0, [f64::MAX, f64::MIN]);
    let n = 400;
    for _ in 0..n {
        steps(&mut task, 1);
        let sim = task.simulator();
        let state = &sim.ball;
        let offsets = [
            state.base_pos[0],
            state.base_pos[2] - 0.8,
            // No angular velocity in the reference: the origin moves as the centre of mass.
            state.base_lin_vel[1] + SPEED,
            state.base_ang_vel[2],
        ];
        for (w, (x, limit)) in widest.iter_mut().zip(offsets.into_iter().zip([0.05, 0.01, 0.5, 0.78])) {
            assert!(x.abs() <= limit + 1e-9, "{offsets:?}");
            *w = w.max(x.abs() / limit);
        }
        let radius = sim.params.ball.radius_m;
        assert_eq!(state.ball_pos[2], radius);
        for k in 0..2 {
            assert!(state.ball_vel[k].abs() <= 0.3);
        }
        // The lowest point of a rolling ball rests: v + omega x (0, 0, -r) = 0.
        assert!((state.ball_vel[0] - state.ball_ang_vel[1] * radius).abs() < 1e-12);
        assert!((state.ball_vel[1] + state.ball_ang_vel[0] * radius).abs() < 1e-12);
        rolling += usize::from(state.ball_vel[0] != 0.0);
        friction = [
            friction[0].min(sim.params.robot.static_friction),
            friction[1].max(sim.params.robot.static_friction),
        ];
        assert!(sim.params.robot.dynamic_friction <= sim.params.robot.static_friction);
    }
    assert!(widest.iter().all(|w| *w > 0.95), "{widest:?}");
    assert!(rolling > n / 3 && rolling < 2 * n / 3, "{rolling}");
    assert!(
        friction[0] > 0.3 && friction[0] < 0.35 && friction[1] < 1.6 && friction[1] > 1.55,
        "{friction:?}"
    );
}

#[test]
fn episodes_begin_well_before_the_strike() {
    let overrides =
        ["sampling.first_frame_share=0", "sampling.latest_start_before_strike_s=0.6", "resets.xy_m=0"];
    let mut task = restless("stage2", &overrides);
    let mut seen = [false; FRAMES];
    for _ in 0..600 {
        steps(&mut task, 1);
        seen[task.sample(0).expect("exists").frame] = true;
    }
    // The strike is at frame 40, 0.6 s are 30 frames.
    assert!((0..=10).all(|t| seen[t]) && (11..FRAMES).all(|t| !seen[t]), "{seen:?}");
}

#[test]
fn a_miss_counts_at_the_strike_where_the_preset_asks() {
    // Without a kick, with one on target, and without the option: what a whole episode adds at the strike (frame 40).
    for (kick_at, weight, expected) in [(1000, "0.5", 0.5), (40, "0.5", 0.0), (1000, "0", 0.0)] {
        let weight = format!("sampling.miss_weight={weight}");
        let mut task = task("stage2", &[&weight], 1, kick_at);
        steps(&mut task, FRAMES - 1);
        assert_eq!(task.take_metrics().ends[EndCause::MotionEnd as usize], 1);
        let failures = task.take_failures();
        assert_eq!(failures.iter().sum::<f32>(), expected, "{kick_at} {weight}");
        assert_eq!(failures[40 * failures.len() / FRAMES], expected, "{kick_at} {weight}");
    }
}

#[test]
fn an_episode_stops_after_the_kick_only_where_the_preset_asks() {
    for (share, expected) in [("1", true), ("0", false)] {
        let share = format!("sampling.stop_share={share}");
        let mut task = task("stage2", &["sampling.stop_after_kick_s=0.1", &share], 1, 40);
        // The kick is step 40; five control steps are 0.1 s.
        let ends = steps(&mut task, 45);
        let ended: Vec<usize> = (0..45).filter(|t| ends[*t].2 == 1).map(|t| t + 1).collect();
        assert_eq!(ended, if expected { vec![45] } else { vec![] }, "{share}");
        assert_eq!(task.take_metrics().ends[EndCause::TimeOut as usize], u64::from(expected));
    }
}

#[test]
fn pushes_come_every_one_to_three_seconds() {
    let mut task = restless("stage1", &[]);
    let options = EvalOptions { max_steps: Some(100_000), disturbances: true, ..EvalOptions::default() };
    task.eval().set_eval(Some(options));
    task.eval().force_start(0, &ForcedStart::nominal(0)).expect("exists");
    let before = task.simulator().pushes.len();
    steps(&mut task, 10_000);
    let pushes = &task.simulator().pushes[before..];
    assert!(pushes.len() > 80 && pushes.len() < 125, "{}", pushes.len());
    for pair in pushes.windows(2) {
        let gap = pair[1].0 - pair[0].0;
        assert!((50..=150).contains(&gap), "{gap}");
    }
    assert!(pushes.iter().all(|(_, v, w)| v[0].abs() <= 0.5 && v[2].abs() <= 0.2 && w[2].abs() <= 0.78));
}
