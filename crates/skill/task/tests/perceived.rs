//! Ball and goal from onboard perception, on the built-in engine with the built-in kicks.

use std::path::Path;
use std::sync::Arc;

use paid_lanes::{Isa, Mat3, Vec3};
use paid_motion::MotionLibrary;
use paid_play::{ReferenceLibrary, RollingBall, motion_for};
use paid_policy::{Pose, SceneView, StepBuffers};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    Agent, EpisodeRules, InitialState, NextKick, ShardSetup, Shown, Task, TaskPreset, TaskSetup, TaskShard,
    build_engine, build_shard, first_look, roll_decay, run_agent,
};

const DT: f64 = 0.02;
const ENVS: usize = 16;
const SEED: u64 = 7;
const PERCEIVED: &str = "knowledge=perceived";
const TERMS: &str = r#"observations.policy=["ball_pos", "ball_at_strike", "goal_pos"]"#;
const CRITIC: &str = r#"observations.critic=["ball_pos", "ball_at_strike", "goal_pos"]"#;
/// Eyes without errors.
const EXACT: [&str; 5] = [
    "eyes.latency_s=[0, 0]",
    "eyes.noise_scale=[0, 0]",
    "eyes.dropout=[0, 0]",
    "eyes.false_share=0",
    "eyes.odometry={offset_m=[0, 0], drift_m_s=[0, 0], heading_drift_deg_s=[0, 0], jitter_m=0, jitter_deg=0}",
];

struct Fixture {
    shard: Box<dyn TaskShard>,
    library: Arc<ReferenceLibrary>,
    preset: TaskPreset,
    height_m: f64,
}

fn fixture(overrides: &[&str], envs: usize) -> Fixture {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::open(Path::new(""), &robot, &spec, 1.0 / DT).expect("the built-in kicks");
    let library = Arc::new(ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("they fit"));
    let overrides: Vec<String> = [TERMS, CRITIC].iter().chain(overrides).map(|s| (*s).to_owned()).collect();
    let preset = TaskPreset::builtin_with("paper_stage2", &overrides).expect("valid");
    let task = TaskSetup {
        robot: &robot,
        spec: &spec,
        library: &library,
        preset: &preset,
        first_env: 0,
        seed: SEED,
    };
    let shard = build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: envs }).expect("builds");
    Fixture { shard, library, preset, height_m: spec.nominal_height_m }
}

/// What policy and critic see: `[who][environment]`, nine numbers each.
fn seen(shard: &mut dyn TaskShard) -> [Vec<[f64; 9]>; 2] {
    let envs = shard.num_envs();
    let (mut policy, mut critic) = (vec![0.0; 9 * envs], vec![0.0; 9 * envs]);
    shard.observe(&mut [&mut policy, &mut critic]);
    [policy, critic]
        .map(|rows| (0..envs).map(|env| std::array::from_fn(|k| f64::from(rows[k * envs + env]))).collect())
}

fn step(shard: &mut dyn TaskShard) {
    let envs = shard.num_envs();
    let actions = vec![0.0; shard.action_dim() * envs];
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; envs], vec![0; envs], vec![0; envs]);
    shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
}

/// Balls that lie or roll before the robot, one an environment.
fn place(fixture: &mut Fixture, velocity: [f64; 2]) {
    fixture.shard.eval().set_rules(EpisodeRules::evaluation());
    for env in 0..ENVS {
        let ball_xy = Some([0.8 + 0.05 * env as f64, 0.3]);
        let motion = env % fixture.library.len();
        let start = InitialState {
            ball_xy,
            ball_velocity: velocity,
            goal_xy: Some([5.0, 0.4]),
            ..InitialState::nominal(motion)
        };
        fixture.shard.eval().force_start(env, &start).expect("exists");
    }
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

#[test]
fn eyes_without_errors_show_nearly_the_truth() {
    for velocity in [[0.0, 0.0], [0.2, -0.15]] {
        let mut f = fixture(&[&[PERCEIVED, "ball_params.angular_damping=0"], &EXACT[..]].concat(), ENVS);
        place(&mut f, velocity);
        for k in 0..10 {
            let [policy, critic] = seen(f.shard.as_mut());
            for (env, (policy, critic)) in policy.iter().zip(&critic).enumerate() {
                // The noise that the filter expects draws a new ball's velocity toward rest: by a tenth after 20 images, over the two to
                // three seconds until the strike.
                assert!(distance(&policy[..3], &critic[..3]) < 0.01, "{k} {env}: {policy:?} {critic:?}");
                assert!(distance(&policy[3..6], &critic[3..6]) < 0.08, "{k} {env}: {policy:?} {critic:?}");
                assert!(distance(&policy[6..], &critic[6..]) < 1e-4, "{k} {env}: {policy:?} {critic:?}");
            }
            step(f.shard.as_mut());
        }
    }
}

#[test]
fn the_policy_is_shown_what_the_robot_makes_of_the_scene_and_the_critic_the_truth() {
    let run = |overrides: &[&str]| {
        let mut f = fixture(overrides, ENVS);
        place(&mut f, [0.0; 2]);
        for _ in 0..10 {
            // Random numbers go by observations.
            seen(f.shard.as_mut());
            step(f.shard.as_mut());
        }
        seen(f.shard.as_mut())
    };
    let ([given, truth], [shown, critic]) = (run(&[]), run(&[PERCEIVED]));
    assert_eq!((&given, &given), (&truth, &critic));
    let error = |at: std::ops::Range<usize>| {
        (0..ENVS).map(|env| distance(&shown[env][at.clone()], &critic[env][at.clone()])).sum::<f64>()
            / ENVS as f64
    };
    // Centimeters for the ball; for the goal 5 m away the offset of 1 cm, 0.2 s of drift, and 0.05 degrees of jitter.
    assert!((0.002..0.06).contains(&error(0..3)), "{}", error(0..3));
    assert!((0.005..0.03).contains(&error(6..9)), "{}", error(6..9));
}

#[test]
fn the_goal_drifts_away_with_odometry() {
    let drifting = "eyes.odometry={offset_m=[0, 0], drift_m_s=[0.05, 0.05], heading_drift_deg_s=[0, 0], \
                    jitter_m=0, jitter_deg=0}";
    let mut f = fixture(&[PERCEIVED, drifting], ENVS);
    place(&mut f, [0.0; 2]);
    for k in 0..25 {
        let [policy, critic] = seen(f.shard.as_mut());
        for env in 0..ENVS {
            let off = distance(&policy[env][6..], &critic[env][6..]);
            assert!((off - 0.05 * DT * f64::from(k)).abs() < 1e-4, "{k} {env}: {off}");
        }
        step(f.shard.as_mut());
    }
}

#[test]
fn an_evaluation_begins_with_the_look_that_its_motion_was_chosen_by() {
    let rolling = [0.15, 0.1];
    let mut f = fixture(&[PERCEIVED], ENVS);
    place(&mut f, rolling);
    let [policy, _] = seen(f.shard.as_mut());
    for (env, shown) in policy.iter().enumerate() {
        let sample = f.shard.eval().sample(env).expect("exists");
        let facts = &f.library.facts()[sample.motion];
        let ball = RollingBall {
            place: [0.8 + 0.05 * env as f64, 0.3],
            velocity: rolling,
            decay: roll_decay(&f.preset.ball_params),
        };
        let believed = first_look(&f.preset.eyes, &ball, f.height_m, SEED, env as u32, 0);
        let base = &sample.bodies[0];
        let world = Mat3(base.rot).mul_vec(Vec3([shown[0], shown[1], shown[2]])) + Vec3(base.pos);
        let (s, c) = facts.heading.sin_cos();
        let [x, y] = [world.x() - facts.start_xy[0], world.y() - facts.start_xy[1]];
        let local = [c * x + s * y, c * y - s * x];
        assert!(distance(&local, &believed.place) < 2e-3, "{env}: {local:?} {believed:?}");
        // It is not the truth, and near it.
        let off = distance(&believed.place, &ball.place);
        assert!((1e-4..0.1).contains(&off), "{env}: {off}");
        assert!(distance(&believed.velocity, &ball.velocity) < 0.2, "{env}: {believed:?}");
    }
}

#[test]
fn training_by_the_workspace_rule_chooses_the_motion_by_what_the_robot_sees() {
    let options = |knowledge| {
        [
            knowledge,
            "ball.rule=workspace",
            "sampling.first_frame_share=1",
            "sampling.miss_sampling_weight=0",
            "eyes.noise_scale=[2, 2]",
            "ball.rolling_share=0",
            "ball.clearance_m=0",
        ]
    };
    let nearest = |knowledge| {
        let f = &mut fixture(&options(knowledge), 512);
        let mut belongs = |env: usize| {
            let sample = f.shard.eval().sample(env).expect("exists");
            let facts = &f.library.facts()[sample.motion];
            let (s, c) = facts.heading.sin_cos();
            let [x, y] = [0, 1].map(|k| sample.ball_pos[k] - facts.start_xy[k]);
            let ball = RollingBall { place: [c * x + s * y, c * y - s * x], velocity: [0.0; 2], decay: 0.0 };
            motion_for(f.library.facts(), &ball, DT) == sample.motion
        };
        (0..512).filter(|env| belongs(*env)).count()
    };
    let (truth, perceived) = (nearest("knowledge=truth"), nearest(PERCEIVED));
    // The built-in kicks lie far apart, so that 10 cm choose another one only near their borders.
    assert_eq!(truth, 512);
    assert!((350..510).contains(&perceived), "{perceived}");
}

#[test]
fn a_restored_shard_sees_on_bit_for_bit() {
    let ranges = [
        PERCEIVED,
        "eyes.latency_s=[0.02, 0.12]",
        "eyes.rate_hz=[15, 60]",
        "eyes.noise_scale=[0.5, 2]",
        "eyes.dropout=[0, 0.3]",
        "eyes.odometry.drift_m_s=[0, 0.02]",
        "ball.rolling_share=0.5",
    ];
    let (mut a, mut b) = (fixture(&ranges, 32).shard, fixture(&ranges, 32).shard);
    run_agent(a.as_mut(), Agent::Random, 40, 3).expect("finite");
    let bytes = a.save();
    run_agent(b.as_mut(), Agent::Random, 7, 4).expect("finite");
    b.restore(&bytes).expect("fits");
    assert!(b.save() == bytes);
    for _ in 0..60 {
        assert_eq!(seen(a.as_mut()), seen(b.as_mut()));
        step(a.as_mut());
        step(b.as_mut());
    }
    assert!(a.save() == b.save());
}

#[test]
fn a_shard_continues_in_groups_of_other_lanes() {
    let ranges =
        [PERCEIVED, "eyes.latency_s=[0.02, 0.12]", "eyes.noise_scale=[0.5, 2]", "ball.rolling_share=0.5"];
    let mut wide = fixture(&ranges, 32);
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let task = TaskSetup {
        robot: &robot,
        spec: &spec,
        library: &wide.library,
        preset: &wide.preset,
        first_env: 0,
        seed: SEED,
    };
    let engine = build_engine::<f64>(&robot, &spec, &wide.preset, 32).expect("fits");
    let mut narrow = Task::new(engine, &task).expect("fits");
    run_agent(wide.shard.as_mut(), Agent::Random, 40, 3).expect("finite");
    run_agent(&mut narrow, Agent::Random, 7, 4).expect("finite");
    goes_on(wide.shard.as_mut(), &mut narrow);
    run_agent(&mut narrow, Agent::Random, 20, 5).expect("finite");
    goes_on(&mut narrow, wide.shard.as_mut());
}

#[test]
fn a_snapshot_of_no_lanes_is_refused() {
    let mut shard = fixture(&[], ENVS).shard;
    let mut bytes = shard.save();
    // Eight bytes that tell what it is; then the numbers of environments and of lanes, a byte each.
    assert_eq!(bytes[8..10], [ENVS as u8, Isa::detect().lanes() as u8]);
    for (lanes, found) in [(0, "found 0"), (7, "found 7")] {
        bytes[9] = lanes;
        let error = shard.restore(&bytes).expect_err("refused");
        assert!(error.contains("lanes: expected a divisor of 16") && error.ends_with(found), "{error}");
    }
}

/// Puts `before` into `after`, which has other lanes, and lets both continue.
fn goes_on(before: &mut dyn TaskShard, after: &mut dyn TaskShard) {
    after.restore(&before.save()).expect("fits");
    // The same to begin with; then contacts round otherwise.
    for apart in [1e-3, 1e-2] {
        let (one, two) = (seen(before), seen(after));
        for (x, y) in one[0].iter().zip(&two[0]) {
            assert!(distance(x, y) < apart, "{x:?} {y:?}");
        }
        step(before);
        step(after);
    }
}

#[test]
fn an_environment_sees_the_same_in_any_lane_type() {
    let mut f = fixture(&[PERCEIVED], ENVS);
    place(&mut f, [0.0; 2]);
    let [wide, _] = seen(f.shard.as_mut());
    // The same environments alone, from the eighth on.
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let task = TaskSetup {
        robot: &robot,
        spec: &spec,
        library: &f.library,
        preset: &f.preset,
        first_env: 8,
        seed: SEED,
    };
    let isa = Isa::Portable;
    let mut shard = build_shard(&ShardSetup { task, isa, num_envs: 8 }).expect("builds");
    shard.eval().set_rules(EpisodeRules::evaluation());
    for env in 0..8 {
        let start = InitialState {
            ball_xy: Some([0.8 + 0.05 * (8 + env) as f64, 0.3]),
            goal_xy: Some([5.0, 0.4]),
            ..InitialState::nominal((8 + env) % f.library.len())
        };
        shard.eval().force_start(env, &start).expect("exists");
    }
    let [narrow, _] = seen(shard.as_mut());
    for env in 0..8 {
        assert!(
            distance(&narrow[env], &wide[8 + env]) < 1e-3,
            "{env}: {:?} {:?}",
            narrow[env],
            wide[8 + env]
        );
    }
}

#[test]
fn values_that_make_no_sense_are_refused_by_key() {
    for (set, hint) in [
        ("eyes.latency_s=[-0.02, 0.06]", "preset: eyes.latency_s is [-0.02, 0.06], expected [lo, hi]"),
        (
            "eyes.camera.down_deg=-40",
            "eyes.camera.down_deg is -40 with a vertical field of view of 42 degrees",
        ),
        ("eyes.c_min=0", "eyes.c_min is 0, expected a positive number"),
        ("eyes.tracker.strike_noise=0", "eyes.tracker.strike_noise is 0"),
        ("eyes.odometry.jitter_m=-1", "eyes.odometry.jitter_m is -1"),
        ("eyes.nonsense=1", "unknown key 'eyes.nonsense'"),
        ("knowledge=guessed", "knowledge"),
    ] {
        let error = TaskPreset::builtin_with("paper_stage2", &[set.to_owned()]).expect_err(set).to_string();
        assert!(error.contains(hint), "{set}: {error}");
    }
}

#[test]
fn the_next_kick_begins_with_a_first_look_of_its_own_number() {
    let next = |look| NextKick {
        motion: 0,
        ball_xy: [1.2, -0.3],
        ball_velocity: [0.0; 2],
        goal_xy: [5.0, 0.5],
        look,
    };
    let run = |look| {
        let mut f = fixture(&[PERCEIVED], ENVS);
        place(&mut f, [0.0; 2]);
        for _ in 0..30 {
            seen(f.shard.as_mut());
            step(f.shard.as_mut());
        }
        (0..ENVS).for_each(|env| f.shard.eval().next_kick(env, &next(look)).expect("exists"));
        seen(f.shard.as_mut())
    };
    let [policy, critic] = run(3);
    for (env, (policy, critic)) in policy.iter().zip(&critic).enumerate() {
        // Twenty images with 2.2 cm of noise each, and a centimeter of odometry.
        assert!(distance(&policy[..3], &critic[..3]) < 0.05, "{env}: {policy:?} {critic:?}");
        assert!(distance(&policy[6..], &critic[6..]) < 0.05, "{env}: {policy:?} {critic:?}");
        assert_ne!(policy[..3], critic[..3], "{env}");
    }
    assert_eq!(run(3)[0], policy);
    assert_ne!(run(4)[0], policy);
}

/// Ball and goal as another program estimates them, in the base frame.
fn shown_scene(ball: [f64; 3]) -> Shown {
    let scene = SceneView {
        ball_at_strike: Vec3([1.0, 2.0, 3.0]),
        ..SceneView::new(Vec3(ball), Vec3([4.0, 0.5, -0.6]))
    };
    Shown { scene, base: Pose { pos: Vec3([5.0, 6.0, 0.8]), rot: Mat3::identity() } }
}

#[test]
fn a_policy_that_is_shown_a_belief_sees_nothing_of_the_simulators_ball() {
    let Fixture { mut shard, .. } = fixture(&[], ENVS);
    let control = shard.eval();
    control.set_rules(EpisodeRules::evaluation());
    for env in 0..ENVS {
        // Every environment has its ball elsewhere, and all are shown the same.
        let ball = [0.6 + 0.05 * env as f64, 0.3 - 0.02 * env as f64];
        let start =
            InitialState { ball_xy: Some(ball), goal_xy: Some([5.0, 0.0]), ..InitialState::nominal(0) };
        control.force_start(env, &start).expect("a start");
        control.show(env, Some(&shown_scene([0.7, -0.1, -0.65]))).expect("shown");
    }
    for _ in 0..3 {
        let [policy, critic] = seen(shard.as_mut());
        let wanted = [0.7, -0.1, -0.65, 1.0, 2.0, 3.0, 4.0, 0.5, -0.6];
        for env in 0..ENVS {
            assert!((0..9).all(|k| (policy[env][k] - wanted[k]).abs() < 1e-5), "{:?}", policy[env]);
            assert!(env == 0 || critic[env] != critic[0], "the critic is given the ground truth");
        }
        step(shard.as_mut());
    }
    let broken = shown_scene([f64::NAN, 0.0, 0.0]);
    let error = shard.eval().show(0, Some(&broken)).expect_err("not a number").to_string();
    assert!(error.contains("not finite"), "{error}");
    // A lane group is shown together; how many environments it has depends on the machine.
    (0..ENVS).for_each(|env| shard.eval().show(env, None).expect("as the task says"));
    let [policy, critic] = seen(shard.as_mut());
    assert_eq!(policy, critic);
}

#[test]
fn the_estimated_ball_lies_where_the_policy_is_shown_it_at_its_own_height() {
    let mut f = fixture(&[&[PERCEIVED], &EXACT[..]].concat(), ENVS);
    place(&mut f, [0.0, 0.0]);
    for _ in 0..3 {
        let [policy, _] = seen(f.shard.as_mut());
        for (env, shown) in policy.iter().enumerate() {
            let control = f.shard.eval();
            let (ball, sample) =
                (control.believed_ball(env).expect("exists"), control.sample(env).expect("exists"));
            let ball = ball.expect("perceived");
            let base = &sample.bodies[0];
            let world = Mat3(base.rot).mul_vec(Vec3([shown[0], shown[1], shown[2]])) + Vec3(base.pos);
            assert!(distance(&ball.pos, &world.0) < 1e-4, "{env}: {:?} {:?}", ball.pos, world.0);
            assert!(distance(&ball.pos, &sample.ball_pos) < 0.01);
            assert!(ball.deviation_m > 0.0 && ball.deviation_m < 0.05, "{ball:?}");
            assert!((0.0..0.1).contains(&ball.age_s), "{ball:?}");
            // 0.8 to 1.5 m ahead and 0.3 m to the left: in the image of a camera that sees 0.5 to 2.4 m ahead.
            assert!(ball.in_view, "{ball:?}");
        }
        step(f.shard.as_mut());
    }
    let behind = InitialState { ball_xy: Some([-1.0, 0.0]), ..InitialState::nominal(0) };
    f.shard.eval().force_start(0, &behind).expect("exists");
    assert!(!f.shard.eval().believed_ball(0).expect("exists").expect("perceived").in_view);
    let mut truth = fixture(&[], ENVS);
    assert_eq!(truth.shard.eval().believed_ball(0).expect("exists"), None);
}
