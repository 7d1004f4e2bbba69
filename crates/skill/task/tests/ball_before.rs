//! Where the ball was shown before, on the built-in engine with the built-in kicks.

use std::path::Path;
use std::sync::Arc;

use paid_lanes::{Isa, Mat3, Vec3};
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_policy::StepBuffers;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{EpisodeRules, InitialState, ShardSetup, TaskPreset, TaskSetup, TaskShard, build_shard};

const DT: f64 = 0.02;
/// One group of the widest lanes.
const ENVS: usize = 16;
const TERMS: [&str; 2] = [
    r#"observations.policy=["ball_pos", "ball_before", "goal_pos"]"#,
    r#"observations.critic=["ball_pos", "ball_before", "goal_pos"]"#,
];

fn shard(overrides: &[&str]) -> Box<dyn TaskShard> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::open(Path::new(""), &robot, &spec, 1.0 / DT).expect("the built-in kicks");
    let library = Arc::new(ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("they fit"));
    let overrides: Vec<String> = TERMS.iter().chain(overrides).map(|s| (*s).to_owned()).collect();
    let preset = TaskPreset::builtin_with("paper_stage2", &overrides).expect("valid");
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 7 };
    build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: ENVS }).expect("builds")
}

/// Balls that roll aside of the robots, which fall over without meeting them.
fn roll(shard: &mut dyn TaskShard, env: usize) {
    let (ball_xy, ball_velocity) = (Some([0.5, 2.5 + 0.1 * env as f64]), [0.25, 0.15]);
    let start = InitialState { ball_xy, ball_velocity, ..InitialState::nominal(env % 2) };
    shard.eval().force_start(env, &start).expect("exists");
}

fn step(shard: &mut dyn TaskShard) {
    let actions = vec![0.0; shard.action_dim() * ENVS];
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; ENVS], vec![0; ENVS], vec![0; ENVS]);
    shard.step(&actions, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
}

/// What policy and critic see: `[who][number][environment]`.
fn seen(shard: &mut dyn TaskShard) -> [Vec<f32>; 2] {
    let mut rows = [vec![0.0; 15 * ENVS], vec![0.0; 15 * ENVS]];
    let [policy, critic] = &mut rows;
    shard.observe(&mut [policy, critic]);
    rows
}

/// The places of the ball now and before in the world `[m]`, as an environment is shown them.
fn places(shard: &mut dyn TaskShard, rows: &[f32], env: usize) -> [[f64; 3]; 4] {
    let base = &shard.eval().sample(env).expect("exists").bodies[0];
    [0, 1, 2, 3].map(|place| {
        let local = Vec3([0, 1, 2].map(|k| f64::from(rows[(3 * place + k) * ENVS + env])));
        (Mat3(base.rot).mul_vec(local) + Vec3(base.pos)).0
    })
}

fn apart(a: [f64; 3], b: [f64; 3]) -> f64 {
    (Vec3(a) - Vec3(b)).norm()
}

#[test]
fn the_ball_is_shown_where_it_was_five_ten_and_fifteen_steps_ago() {
    let mut shard = shard(&[]);
    shard.eval().set_rules(EpisodeRules::evaluation());
    (0..ENVS).for_each(|env| roll(shard.as_mut(), env));
    let mut way: Vec<Vec<[f64; 3]>> = vec![Vec::new(); ENVS];
    for k in 0..45 {
        if k == 25 {
            // Half of them begin anew.
            (0..ENVS / 2).for_each(|env| {
                roll(shard.as_mut(), env);
                way[env].clear();
            });
        }
        // Whoever looks twice at a step sees the same.
        assert_eq!(seen(shard.as_mut()), seen(shard.as_mut()));
        let [policy, critic] = seen(shard.as_mut());
        assert_eq!(policy, critic, "nothing disturbs what is seen");
        for (env, way) in way.iter_mut().enumerate() {
            let [now, before @ ..] = places(shard.as_mut(), &policy, env);
            let ball = shard.eval().sample(env).expect("exists").ball_pos;
            assert!(apart(now, ball) < 1e-4, "{env}: {now:?} {ball:?}");
            way.push(ball);
            for (ago, place) in [5, 10, 15].into_iter().zip(before) {
                let expected = way[way.len().saturating_sub(ago + 1)];
                assert!(apart(place, expected) < 1e-4, "step {k}, {env}, {ago}: {place:?} {expected:?}");
            }
        }
        step(shard.as_mut());
    }
    let moved = apart(way[ENVS - 1][0], way[ENVS - 1][44]);
    assert!(moved > 0.1, "{moved}");
}

#[test]
fn a_snapshot_has_what_was_shown_before() {
    let options = ["knowledge=perceived"];
    let (mut one, mut two) = (shard(&options), shard(&options));
    (0..ENVS).for_each(|env| roll(one.as_mut(), env));
    for _ in 0..12 {
        seen(one.as_mut());
        step(one.as_mut());
    }
    two.restore(&one.save()).expect("fits");
    for _ in 0..20 {
        let [policy, critic] = seen(one.as_mut());
        assert_ne!(policy[..12 * ENVS], critic[..12 * ENVS], "the policy is shown a belief");
        assert_eq!([policy, critic], seen(two.as_mut()));
        step(one.as_mut());
        step(two.as_mut());
    }
}
