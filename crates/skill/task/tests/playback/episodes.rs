//! How episodes begin and end, and what is shown of them.

use std::path::Path;

use paid_motion::MotionLibrary;
use paid_play::{ReferenceClip, ReferenceLibrary};
use paid_policy::{StepBuffers, VecEnv};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    AfterEnd, Disturbances, EndCause, EpisodeRules, EvalControl, InitialState, RewardTermsInSamples, Task,
    TaskPreset, TaskShard, TimeLimit, TrainShard, reward_names,
};

use super::simulator::{FRAMES, Playback, SPEED, clip, playback, playback_with_height, steps, task};

#[test]
fn a_state_that_is_not_finite_ends_the_episode_and_nothing_else() {
    let mut task = playback_with_height(f64::NAN);
    let (reward, terminated, truncated) = steps(&mut task, 1)[0];
    assert_eq!((reward, terminated, truncated), (0.0, 1, 0));
    let metrics = task.take_metrics();
    assert_eq!(metrics.ends[EndCause::NotFinite.index()], 1);
    assert!(metrics.reward_terms.iter().chain(&metrics.tracking).all(|x| *x == 0.0));
}

#[test]
fn an_evaluation_holds_the_last_frame_and_obeys_the_forced_start() {
    let mut task = task("stage2", &["sampling.first_frame_share=0"], 1, usize::MAX);
    task.eval().set_rules(EpisodeRules { time_limit: TimeLimit::Steps(80), ..EpisodeRules::evaluation() });
    let start = InitialState {
        ball_xy: Some([1.0, 0.25]),
        ball_velocity: [0.1, 0.2],
        goal_xy: Some([5.0, -1.0]),
        ..InitialState::nominal(0)
    };
    task.eval().force_start(0, &start).expect("exists");
    let sample = task.sample(0).expect("exists");
    // The motion faces -y: one meter ahead is at y = -1, left is +x.
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
    assert!(task.eval().force_start(0, &InitialState::nominal(1)).is_err());
    assert!(task.eval().force_start(1, &InitialState::nominal(0)).is_err());
}

#[test]
fn the_reward_terms_of_a_sample_add_up_to_the_reward_and_are_there_on_request_only() {
    let mut task = task("stage2", &[], 1, 20);
    for reward_terms in [RewardTermsInSamples::Kept, RewardTermsInSamples::Dropped] {
        task.eval().set_rules(EpisodeRules { reward_terms, ..EpisodeRules::evaluation() });
        task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
        for _ in 0..25 {
            let (reward, ..) = steps(&mut task, 1)[0];
            let terms = task.sample(0).expect("exists").rewards;
            if reward_terms == RewardTermsInSamples::Kept {
                assert_eq!(terms.len(), reward_names().len());
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
    task.eval().set_rules(EpisodeRules::evaluation());
    task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
    let actions: Vec<f32> = (0..task.action_dim()).map(|j| 0.01 * j as f32).collect();
    task.step(&actions, StepBuffers::new(&mut [0.0], &mut [0], &mut [0]));
    let mut policy = vec![9.0; task.policy_obs_dim()];
    let mut critic = vec![9.0; task.critic_obs_dim()];
    task.observe(&mut [&mut policy, &mut critic]);
    let layout = task.layout().clone();
    let slice = |name: &str| policy[layout.policy.place(name).expect("a term")].to_vec();
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
    let base_vel = layout.critic.place("base_lin_vel").expect("a term").start;
    assert!((critic[base_vel] - SPEED as f32).abs() < 1e-6);
}

/// A task with the preset's own noise whose episodes last one step.
fn restless(name: &str, more: &[&str]) -> Task<f64, Playback> {
    let overrides: Vec<String> = more.iter().map(|s| (*s).to_owned()).collect();
    let preset = TaskPreset::builtin_with(&format!("paper_{name}"), &overrides).expect("valid");
    let clip = clip(&RobotModel::g1(), &RobotSpec::g1(), 1);
    let mut task = playback(clip, &preset, usize::MAX, |_| ());
    task.eval().set_rules(EpisodeRules {
        time_limit: TimeLimit::Steps(1),
        after_end: AfterEnd::Restart,
        disturbances: Disturbances::AsPreset,
        ..EpisodeRules::evaluation()
    });
    task
}

#[test]
fn starts_are_the_references_plus_the_presets_noise() {
    let mut task = restless("stage2", &["sampling.first_frame_share=1", "randomization.robot=true"]);
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
            // No angular velocity in the reference: the origin moves as the center of mass.
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
fn a_miss_counts_at_the_strike_where_the_preset_says_so() {
    // Without a kick, with one on target, and without the option: what a whole episode adds at the strike (frame 40).
    for (kick_at, weight, expected) in [(1000, "0.5", 0.5), (40, "0.5", 0.0), (1000, "0", 0.0)] {
        let weight = format!("sampling.miss_sampling_weight={weight}");
        let mut task = task("stage2", &[&weight], 1, kick_at);
        steps(&mut task, FRAMES - 1);
        assert_eq!(task.take_metrics().ends[EndCause::MotionEnd.index()], 1);
        let failures = task.take_failures();
        assert_eq!(failures.iter().sum::<f32>(), expected, "{kick_at} {weight}");
        assert_eq!(failures[40 * failures.len() / FRAMES], expected, "{kick_at} {weight}");
    }
}

#[test]
fn an_episode_stops_after_the_kick_only_where_the_preset_says_so() {
    for (share, expected) in [("1", true), ("0", false)] {
        let share = format!("sampling.stop_share={share}");
        let mut task = task("stage2", &["sampling.stop_after_kick_s=0.1", &share], 1, 40);
        // The kick is step 40; five control steps are 0.1 s.
        let ends = steps(&mut task, 45);
        let ended: Vec<usize> = (0..45).filter(|t| ends[*t].2 == 1).map(|t| t + 1).collect();
        assert_eq!(ended, if expected { vec![45] } else { vec![] }, "{share}");
        assert_eq!(task.take_metrics().ends[EndCause::TimeOut.index()], u64::from(expected));
    }
}

#[test]
fn pushes_come_every_one_to_three_seconds() {
    let mut task = restless("stage1", &[]);
    task.eval().set_rules(EpisodeRules {
        time_limit: TimeLimit::Steps(100_000),
        disturbances: Disturbances::AsPreset,
        ..EpisodeRules::evaluation()
    });
    task.eval().force_start(0, &InitialState::nominal(0)).expect("exists");
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

#[test]
fn the_strike_is_the_frame_that_the_motion_states() {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let strike = |stated| {
        let clip = ReferenceClip { strike_frame: stated, ..clip(&robot, &spec, 1) };
        ReferenceLibrary::new(vec![clip], &robot, &spec).map(|library| library.facts()[0].clone())
    };
    // The foot is fastest in frame 40.
    for (stated, frame, speed) in [(None, 40, 5.0), (Some(37), 37, SPEED)] {
        let facts = strike(stated).expect("fits");
        assert_eq!((facts.strike_frame, facts.strike_speed), (frame, speed));
    }
    let error = strike(Some(FRAMES)).expect_err("beyond the end").to_string();
    assert!(error.contains("expected a strike frame from 0 to 59, found 60"), "{error}");
}

#[test]
fn a_file_that_states_its_kick_frame_brings_it_to_the_task() {
    let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
    let mut motions = MotionLibrary::open(Path::new(""), &robot, &spec, 50.0).expect("the built-in kicks");
    let stated = motions.clips[0].kick_frame.expect("the built-in kicks state it");
    motions.clips[0].kick_frame = Some(stated - 5);
    let library = ReferenceLibrary::from_motions(&motions, &robot, &spec).expect("fits");
    assert_eq!(library.facts()[0].strike_frame, stated - 5);
}
