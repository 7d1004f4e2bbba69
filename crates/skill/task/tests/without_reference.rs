//! A task without a reference motion, on the built-in engine: an agent, falls, the time limit, a kick with either foot.

use std::sync::Arc;

use paid_lanes::Isa;
use paid_play::{ReferenceLibrary, STANDING_BALL_M};
use paid_policy::StepBuffers;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    Agent, EndCause, EpisodeRules, ShardSetup, TaskError, TaskMetrics, TaskPreset, TaskSetup, TaskShard,
    build_shard, run_agent,
};

const ENVS: usize = 32;

/// `stage2` without a reference: what tracks is off, and the ball lies anywhere in the workspace.
fn preset(more: &[&str]) -> TaskPreset {
    let overrides = [
        "reference=none",
        r#"observations.policy=["projected_gravity", "base_ang_vel", "joint_pos_rel", "joint_vel", "last_action", "ball_pos", "goal_pos"]"#,
        r#"observations.critic=["base_lin_vel", "base_ang_vel", "joint_pos_rel", "joint_vel", "body_pos", "ball_pos", "goal_pos"]"#,
        "episode_length_s=2.0",
        "rewards.anchor_ori.weight=0",
        "rewards.body_pos.weight=0",
        "rewards.body_ori.weight=0",
        "rewards.lin_vel.weight=0",
        "rewards.ang_vel.weight=0",
        "rewards.foot_pos.weight=0",
        "terminations.anchor_height.limit_m=0",
        "terminations.gravity.limit=0",
        "terminations.end_effector.limit_m=0",
        "terminations.fallen={ height_m = 0.4, tilt_deg = 60.0 }",
        "ball.rule=workspace",
    ];
    parse(&overrides.iter().chain(more).copied().collect::<Vec<_>>()).expect("valid")
}

fn parse(overrides: &[&str]) -> Result<TaskPreset, TaskError> {
    let overrides: Vec<String> = overrides.iter().map(|s| (*s).to_owned()).collect();
    TaskPreset::builtin_with("paper_stage2", &overrides)
}

fn shard(more: &[&str]) -> Box<dyn TaskShard> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let preset = preset(more);
    let library = ReferenceLibrary::standing(&robot, &spec, preset.control_dt_s()).expect("fits");
    let library = Arc::new(library);
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 3 };
    build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: ENVS }).expect("builds")
}

fn end(metrics: &TaskMetrics, cause: EndCause) -> u64 {
    metrics.ends[cause.index()]
}

#[test]
fn a_random_agent_falls_and_nothing_else_ends_its_episodes() {
    let mut shard = shard(&[]);
    let metrics = run_agent(shard.as_mut(), Agent::Random, 200, 1).expect("finite observations and rewards");
    let fallen = end(&metrics, EndCause::Fallen);
    assert!(fallen >= ENVS as u64, "{:?}", metrics.ends);
    assert_eq!(fallen + end(&metrics, EndCause::TimeOut), metrics.episodes);
    assert_eq!(metrics.tracking, [0.0; paid_task::TRACKING_NAMES.len()]);
    assert_eq!(shard.take_failures().iter().sum::<f32>(), fallen as f32);
}

#[test]
fn without_a_fall_the_time_limit_ends_the_episode() {
    let mut shard = shard(&["terminations.fallen.height_m=0", "terminations.fallen.tilt_deg=0"]);
    let metrics = run_agent(shard.as_mut(), Agent::Zero, 101, 1).expect("finite");
    // 2 s are 100 control steps.
    assert_eq!((metrics.episodes, end(&metrics, EndCause::TimeOut)), (ENVS as u64, ENVS as u64));
    assert_eq!(metrics.episode_steps, 100 * ENVS as u64);
}

#[test]
fn episodes_begin_in_the_standing_pose_with_ball_and_goal_ahead() {
    let mut shard = shard(&[]);
    let spec = RobotSpec::g1();
    let default = spec.resolve(&RobotModel::g1()).expect("fits").default_pos;
    for env in 0..ENVS {
        let sample = shard.eval().sample(env).expect("exists");
        assert!((sample.bodies[0].pos[2] - spec.nominal_height_m).abs() < 0.02, "{:?}", sample.bodies[0].pos);
        assert!(sample.joint_pos.iter().zip(&default).all(|(q, d)| (q - d).abs() < 0.11));
        assert!(
            (0.0..2.6).contains(&sample.ball_pos[0]) && sample.ball_pos[1].abs() < 1.6,
            "{:?}",
            sample.ball_pos
        );
        assert!(
            (sample.goal_pos[0] - 5.0).abs() < 0.3 && sample.goal_pos[1].abs() < 0.6,
            "{:?}",
            sample.goal_pos
        );
        assert!(!sample.motion_ended);
    }
    shard.eval().set_rules(EpisodeRules::evaluation());
    shard.eval().force_start(0, &paid_task::InitialState::nominal(0)).expect("exists");
    let ball = shard.eval().sample(0).expect("exists").ball_pos;
    assert!((ball[0] - STANDING_BALL_M).abs() < 0.02 && ball[1].abs() < 0.02, "{ball:?}");
}

#[test]
fn eyes_expect_no_strike_where_no_reference_says_one() {
    // What they believe in the first 0.3 s of an episode.
    let believed = |noise: &str| {
        let mut shard = shard(&["knowledge=perceived", noise]);
        let actions = vec![0.0; shard.action_dim() * ENVS];
        let (mut reward, mut terminated, mut truncated) = ([0.0; ENVS], [0; ENVS], [0; ENVS]);
        let mut beliefs = Vec::new();
        for _ in 0..15 {
            shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
            for env in 0..ENVS {
                beliefs.push(shard.eval().believed_ball(env).expect("exists").expect("perceived"));
            }
        }
        beliefs
    };
    assert_eq!(believed("eyes.tracker.strike_noise=8.0"), believed("eyes.tracker.strike_noise=0.001"));
}

#[test]
fn a_term_that_needs_a_reference_is_refused_by_name() {
    let good = toml::to_string(&preset(&[])).expect("writes");
    for (set, expected) in [
        (
            r#"observations.policy=["reference_joint_pos"]"#,
            "observation term 'reference_joint_pos' needs a reference motion",
        ),
        (
            r#"observations.critic=["anchor_pos_error"]"#,
            "observation term 'anchor_pos_error' needs a reference motion",
        ),
        ("rewards.kick_foot_vel.weight=1", "reward term 'kick_foot_vel' needs a reference motion"),
        ("terminations.gravity.limit=0.8", "termination term 'gravity' needs a reference motion"),
    ] {
        let error =
            TaskPreset::parse("x", &good, &[set.to_owned()]).expect_err("needs a reference").to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn preset_and_library_must_agree_on_the_reference() {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let library = Arc::new(ReferenceLibrary::standing(&robot, &spec, 0.02).expect("fits"));
    let preset = TaskPreset::builtin("paper_stage2").expect("valid");
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 3 };
    let built = build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: ENVS });
    let error = built.err().expect("refused").to_string();
    assert_eq!(error, "reference library: the preset follows reference motions, the library only stands");
}
