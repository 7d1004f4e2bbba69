//! The built-in kicks to the left are the mirror images of those to the right: what the policy sees of them is too.

use std::path::Path;
use std::sync::Arc;

use paid_lanes::Isa;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_policy::matrix::{Mat, MatMut};
use paid_policy::{Mirror, ObservationTerms, StepBuffers};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{EpisodeRules, InitialState, ShardSetup, TaskPreset, TaskSetup, TaskShard, build_shard};

/// One group of the widest lanes.
const ENVS: usize = 16;
/// Environment of the kick by the right foot, and of that by the left one.
const SIDES: [usize; 2] = [0, 1];

fn mirrored(mirror: &Mirror, x: &[f32]) -> Vec<f32> {
    let mut out = vec![0.0; x.len()];
    mirror.apply(Mat::new(x, x.len(), 1, 1), MatMut::new(&mut out, x.len(), 1, 1));
    out
}

/// What the policy of either environment sees, and what the critic does.
fn seen(shard: &mut dyn TaskShard) -> [[Vec<f32>; 2]; 2] {
    let dims = [shard.policy_obs_dim(), shard.critic_obs_dim()];
    let [mut policy, mut critic] = dims.map(|rows| vec![0.0; rows * ENVS]);
    shard.observe(&mut [&mut policy, &mut critic]);
    [policy, critic].map(|group| SIDES.map(|env| group.iter().skip(env).step_by(ENVS).copied().collect()))
}

/// A kick by the right foot, and the image of it by the left one; the task with these overrides.
fn started(sets: &[&str]) -> Box<dyn TaskShard> {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let motions = MotionLibrary::open(Path::new(""), &robot, &spec, 50.0).expect("the built-in kicks");
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    let preset = TaskPreset::builtin_with("paper_stage2", &sets).expect("valid");
    let library = Arc::new(
        ReferenceLibrary::for_play(&motions, &robot, &spec, &preset.play_preset()).expect("they fit"),
    );
    let task =
        TaskSetup { robot: &robot, spec: &spec, library: &library, preset: &preset, first_env: 0, seed: 7 };
    let mut shard = build_shard(&ShardSetup { task, isa: Isa::detect(), num_envs: ENVS }).expect("builds");
    shard.eval().set_rules(EpisodeRules::evaluation());
    let motion = |name: &str| library.clips().iter().position(|c| c.name == name).expect("a built-in kick");
    let (right, left) = (motion("standard_04_right"), motion("standard_02_left"));
    for (env, motion, side) in [(SIDES[0], right, 1.0), (SIDES[1], left, -1.0)] {
        let start = InitialState {
            frame: 40,
            ball_xy: Some([1.2, -0.3 * side]),
            goal_xy: Some([5.0, 0.4 * side]),
            ..InitialState::nominal(motion)
        };
        shard.eval().force_start(env, &start).expect("exists");
    }
    shard
}

/// Actions of a step for both: what is done, and `of_left` of it by the left foot's kick.
fn act(shard: &mut dyn TaskShard, step: usize, of_left: impl Fn(&[f32]) -> Vec<f32>) {
    let joints = shard.action_dim();
    let (mut reward, mut terminated, mut truncated) = (vec![0.0; ENVS], vec![0; ENVS], vec![0; ENVS]);
    let action: Vec<f32> = (0..joints).map(|j| ((7 * j + 3 * step) % 11) as f32 * 0.06 - 0.3).collect();
    let actions = [action.clone(), of_left(&action)];
    let mut all = vec![0.0; joints * ENVS];
    for (env, action) in SIDES.into_iter().zip(&actions) {
        for (j, value) in action.iter().enumerate() {
            all[j * ENVS + env] = *value;
        }
    }
    shard.step(&all, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
    assert_eq!(SIDES.map(|env| terminated[env] + truncated[env]), [0, 0], "step {step}");
}

/// Terms of a group, row by row.
fn rows(group: &ObservationTerms) -> Vec<(usize, String)> {
    group.places().flat_map(|(place, term)| place.map(move |row| (row, term.name.clone()))).collect()
}

/// The same up to the effect, by this step, of the robot's parts that are not quite symmetric.
fn agree(names: &[(usize, String)], step: usize, [expected, found]: [&[f32]; 2]) {
    let allowed = if step == 0 { 1e-4 } else { 0.05 };
    for (row, name) in names {
        let apart = (expected[*row] - found[*row]).abs();
        let speeds = if name.contains("vel") { 10.0 } else { 1.0 };
        assert!(apart < speeds * allowed, "{step}: {name}: {} {}", expected[*row], found[*row]);
    }
}

#[test]
fn what_the_left_foots_kick_sees_is_the_image_of_what_the_right_foots_sees() {
    let mut shard = started(&[]);
    let mirrors = shard.mirrors().expect("a G1 has two sides");
    let names = rows(&shard.layout().policy);
    for step in 0..6 {
        let [[right, left], _] = seen(shard.as_mut());
        agree(&names, step, [&mirrored(&mirrors.observation, &right), &left]);
        act(shard.as_mut(), step, |action| mirrored(&mirrors.action, action));
    }
}

#[test]
fn played_in_the_mirror_both_kicks_are_one() {
    let robot = RobotModel::g1();
    let mut shard = started(&["mirror_left_kicks=true"]);
    let names = [rows(&shard.layout().policy), rows(&shard.layout().critic)];
    for step in 0..6 {
        for (names, [right, left]) in names.iter().zip(seen(shard.as_mut())) {
            agree(names, step, [&right, &left]);
        }
        act(shard.as_mut(), step, <[f32]>::to_vec);
        let knees =
            ["right_knee_joint", "left_knee_joint"].map(|name| robot.joint_index(name).expect("a joint"));
        let [right, left] =
            [0, 1].map(|k| shard.eval().sample(SIDES[k]).expect("exists").joint_pos[knees[k]]);
        assert!((right - left).abs() < 0.05, "step {step}: knees at {right} and {left} rad");
    }
}

#[test]
fn a_mirror_needs_a_reference() {
    let sets = ["reference=none".to_owned(), "mirror_left_kicks=true".to_owned()];
    let error = TaskPreset::builtin_with("paper_stage2", &sets).expect_err("refused").to_string();
    assert!(error.contains("mirror_left_kicks") && error.contains("reference"), "{error}");
}
