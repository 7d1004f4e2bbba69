//! What tracking and kicks are paid.

use paid_robot::{RobotModel, RobotSpec};
use paid_task::{EndCause, EvalControl, TrainShard, reward_names};

use super::simulator::{FRAMES, clip, playback, playback_with_height, preset, steps, task, term};

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
        (metrics.episodes, metrics.ends[EndCause::MotionEnd.index()], metrics.episode_steps),
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
fn a_robot_that_stays_behind_fails_by_anchor_distance_only_where_the_preset_says_so() {
    for (limit, ends) in [("0.0", 0), ("0.5", 1)] {
        let clip = clip(&RobotModel::g1(), &RobotSpec::g1(), 1);
        let set = format!("terminations.anchor_distance.limit_m={limit}");
        let mut task = playback(clip, &preset("stage1", &[&set]), usize::MAX, |sim| sim.aside = 0.6);
        assert_eq!(steps(&mut task, 1)[0].1, ends);
        assert_eq!(task.take_metrics().ends[EndCause::AnchorDistance.index()], u64::from(ends));
    }
}

/// A robot 0.3 m too high: anchor position exp(-1), body positions exp(-1), the other four terms 1.
fn broken_reward() -> f32 {
    (0.02 * (4.0 + 2.0 * (-1.0_f64).exp())) as f32
}

#[test]
fn a_kick_with_the_labeled_foot_earns_contact_swing_and_outcome() {
    let mut right = task("stage2", &[], 1, 40);
    steps(&mut right, 39);
    right.take_metrics();
    steps(&mut right, 1);
    let metrics = right.take_metrics();
    let value =
        |name: &str| metrics.reward_terms[reward_names().iter().position(|n| *n == name).expect("a term")];
    assert!((value("contact") - 1.0).abs() < 1e-12);
    // The foot's velocity is along its x axis: no side kick.
    assert!(value("side_kick").abs() < 1e-9);
    assert!((value("speed") - 10.0 * 0.02 * (1.0 - (-16.0_f64 / 1.44).exp())).abs() < 1e-9);
    assert!((value("z_speed") + 0.2 * 0.02 * (1.0_f64 / 3.0).tanh()).abs() < 1e-9);
    assert!(value("vel_align") > 0.5 * 30.0 * 0.02);
    steps(&mut right, 10);
    let later = right.take_metrics();
    let value =
        |name: &str| later.reward_terms[reward_names().iter().position(|n| *n == name).expect("a term")];
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
fn a_touch_long_before_the_strike_earns_nothing() {
    // The reference strikes in frame 40; 0.2 s are ten frames.
    for (kick_at, rewarded) in [(29, 0), (30, 1), (40, 1)] {
        let mut early = task("stage2", &["rewards.kick.early_s=0.2"], 1, kick_at);
        steps(&mut early, FRAMES - 1);
        let kick = early.take_metrics().kick;
        assert_eq!((kick.contacts, kick.correct_foot), (1, rewarded), "{kick_at}");
    }
}

#[test]
fn a_kick_with_the_other_foot_earns_nothing() {
    let mut left = task("stage2", &[], 0, 40);
    steps(&mut left, 50);
    let metrics = left.take_metrics();
    for name in ["contact", "side_kick", "vel_align", "speed"] {
        let index = reward_names().iter().position(|n| *n == name).expect("a term");
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
