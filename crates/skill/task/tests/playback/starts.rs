//! Holding the last pose, and episodes that begin elsewhere than in a frame of the approach.

use paid_lanes::Quat;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::{
    AfterEnd, Disturbances, EndCause, EpisodeRules, EvalControl, Task, TaskPreset, TaskShard, TimeLimit,
    TrainShard, reward_names,
};

use super::simulator::{FRAMES, Playback, SPEED, clip, playback, preset, steps, task};

/// Undisturbed starts of 200 episodes that last one step each.
fn starts(more: &[&str], mut each: impl FnMut(&Task<f64, Playback>)) {
    let mut task = task("stage2", more, 1, usize::MAX);
    task.eval().set_rules(EpisodeRules {
        time_limit: TimeLimit::Steps(1),
        after_end: AfterEnd::Restart,
        disturbances: Disturbances::Off,
        ..EpisodeRules::evaluation()
    });
    for _ in 0..200 {
        steps(&mut task, 1);
        each(&task);
    }
    assert_eq!(task.take_metrics().episodes, 200);
}

#[test]
fn the_last_pose_is_held_as_long_as_the_preset_says() {
    for (hold, expected) in [("[0.0, 0.0]", [FRAMES - 1; 2]), ("[0.2, 0.6]", [FRAMES + 9, FRAMES + 29])] {
        let mut task = task("stage2", &[&format!("hold_s={hold}")], 1, usize::MAX);
        let ends = steps(&mut task, 4000);
        let at: Vec<usize> = (0..4000).filter(|t| ends[*t].2 == 1).map(|t| t + 1).collect();
        let lengths: Vec<usize> =
            at.iter().zip([0].iter().chain(&at)).map(|(end, begin)| end - begin).collect();
        assert!(lengths.iter().all(|n| (expected[0]..=expected[1]).contains(n)), "{hold}: {lengths:?}");
        let spread = lengths.iter().max().zip(lengths.iter().min()).expect("episodes");
        assert!(spread.0 - spread.1 >= (expected[1] - expected[0]) / 2, "{hold}: {lengths:?}");
        assert_eq!(task.take_metrics().ends[EndCause::MotionEnd.index()], lengths.len() as u64);
    }
}

#[test]
fn episodes_after_the_strike_have_their_ball_gone_and_count_no_kick() {
    let options = [
        "hold_s=[0.2, 0.2]",
        "sampling.after_strike_share=1",
        "goal.rectangle_across_m=0",
        "rewards.ball_prox.sigma=0.5",
    ];
    let mut seen = [0; FRAMES];
    starts(&options, |task| {
        let (frame, ball) = (task.sample(0).expect("exists").frame, &task.simulator().ball);
        seen[frame] += 1;
        assert!((40..FRAMES).contains(&frame), "{frame}");
        // It lay 0.59 m ahead, which is -y, and left at the strike, frame 40; the last pose is the one that is held.
        let way = -0.59 - ball.ball_pos[1];
        let since_s = 0.02 * (frame as f64 - 40.0);
        let held = frame == FRAMES - 1;
        let expected = 0.5 + 3.0 * since_s;
        let late = way - expected;
        assert!(late.abs() < 1e-9 || held && late > 0.0 && late < 0.2 * 3.0 + 1e-9, "{frame}: {way}");
        assert!((ball.ball_vel[1] + 3.0).abs() < 1e-9);
        assert_eq!(ball.base_lin_vel[1] == 0.0, late > 1e-9, "the held pose is at rest");
    });
    // 29 starts, ten of which are held.
    assert!(seen[40] > 0 && seen[FRAMES - 1] > 40 && seen[FRAMES - 1] < 110, "{seen:?}");

    let mut task = task("stage2", &options, 1, usize::MAX);
    steps(&mut task, 300);
    let metrics = task.take_metrics();
    assert!(metrics.episodes >= 10 && metrics.kick.episodes == 0, "{metrics:?}");
    // The reward for nearness stays as at the contact, whose ball the reference had 0.19 m ahead.
    let weight = preset("stage2", &options).rewards.ball_prox.weight;
    let expected = 300.0 * 0.02 * weight * (-(0.19_f64 / 0.5).powi(2)).exp();
    let nearness =
        metrics.reward_terms[reward_names().iter().position(|n| *n == "ball_prox").expect("a term")];
    assert!(expected > 0.0 && (nearness - expected).abs() < 1e-6, "{nearness}, expected {expected}");
}

#[test]
fn a_start_in_another_pose_is_at_rest_and_turned_a_little() {
    let (mut widest, mut taken) = (0.0_f64, 0);
    starts(&["sampling.from_last_pose_share=0.5"], |task| {
        let state = &task.simulator().ball;
        let [w, x, y, z] = state.base_quat;
        let turn = (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z)) + core::f64::consts::FRAC_PI_2;
        assert!(state.base_pos[0].abs() < 1e-9 && (state.base_pos[2] - 0.8).abs() < 1e-9);
        if state.base_lin_vel[1] == 0.0 {
            taken += 1;
            widest = widest.max(turn.abs());
        } else {
            assert!(turn.abs() < 1e-9 && (state.base_lin_vel[1] + SPEED).abs() < 1e-9);
        }
    });
    assert!((70..130).contains(&taken) && widest > 0.13 && widest <= 0.15 + 1e-9, "{taken}, {widest}");
}

#[test]
fn episodes_begin_in_the_states_that_held_ones_ended_in() {
    let options = ["hold_s=[0.1, 0.1]", "sampling.from_end_state_share=1"];
    let robot = (RobotModel::g1(), RobotSpec::g1());
    let mut task = playback(clip(&robot.0, &robot.1, 1), &preset("stage2", &options), usize::MAX, |sim| {
        sim.foot_height = 0.05;
    });
    let height = |task: &Task<f64, Playback>| task.simulator().ball.base_pos[2];
    assert!((height(&task) - 0.8).abs() < 1e-9, "no episode has ended yet");
    steps(&mut task, FRAMES + 4);
    assert_eq!(task.take_metrics().ends[EndCause::MotionEnd.index()], 1);
    let state = &task.simulator().ball;
    // The simulator shows every body 5 cm higher than the reference.
    assert!((state.base_pos[2] - 0.85).abs() < 1e-9, "{state:?}");
    let ahead = Quat(state.base_quat).rotate(paid_lanes::Vec3([1.0, 0.0, 0.0])).0;
    assert!(ahead[1] < -0.98, "it looks along the motion: {ahead:?}");
}

#[test]
fn bad_shares_and_times_are_named() {
    let stage2 = TaskPreset::builtin("paper_stage2").expect("valid");
    for (set, message) in [
        (
            &["sampling.from_end_state_share=0.2"][..],
            "sampling.from_end_state_share is 0.2, expected 0 while hold_s",
        ),
        (&["sampling.after_strike_share=1.5"], "sampling.after_strike_share is 1.5, expected a share"),
        (
            &["hold_s=[0, 1]", "sampling.from_last_pose_share=0.75", "sampling.from_end_state_share=0.5"],
            "sampling.from_last_pose_share + from_end_state_share is 1.25, expected at most 1",
        ),
        (&["hold_s=[-1, 1]"], "hold_s is [-1.0, 1.0], expected times from 0 to 60 s"),
    ] {
        let set: Vec<String> = set.iter().map(|s| (*s).to_owned()).collect();
        let error = stage2.with_overrides(&set).expect_err("bad").to_string();
        assert!(error.contains(message), "{error}");
    }
}
