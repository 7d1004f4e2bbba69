//! A whole retargeting of a human made of numbers; needs no data.

use std::path::Path;

use paid_motion::KickLeg;
use paid_motion::check::{CheckLimits, check_clip};
use paid_motion::clean::{CleanOptions, clean};
use paid_retarget::{HumanMotion, RetargetOptions, TimeScale, parse_bvh, retarget};
use paid_robot::{RobotModel, RobotSpec};

fn human() -> HumanMotion {
    parse_bvh(&crate::common::kick_bvh(130), Path::new("kick.bvh"), 0.01).expect("a good file")
}

#[test]
fn a_standing_human_becomes_a_standing_robot_that_kicks_with_the_same_leg() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let out = retarget(&human(), &model, &spec, &RetargetOptions::default()).expect("a human");
    let (clip, report) = (&out.clip, &out.report);
    assert_eq!((clip.fps, clip.kick_leg), (50.0, KickLeg::Right));
    assert_eq!(clip.frames, 108, "130 frames at 60 Hz last 2.15 s");
    assert!(report.kick_speed > 1.5, "{report:?}");
    assert!(report.rotation_error < 0.1, "{report:?}");
    // Upright above the origin, looking along x, soles flat on the ground.
    let [w, ..] = clip.body_quat(0)[0];
    assert!(w > 0.995, "{:?}", clip.body_quat(0)[0]);
    assert!(clip.body_pos(0)[0][0].abs() < 1e-9 && clip.body_pos(0)[0][1].abs() < 1e-9);
    let left = model.body_index("left_ankle_roll_link").expect("a foot");
    for t in 0..clip.frames {
        let [w, x, y, _] = clip.body_quat(t)[left];
        assert!(w > 0.99 && x.abs() + y.abs() < 0.03, "frame {t}: the left foot stays flat");
    }
    assert!(report.penetration_m.abs() < 0.01, "{report:?}");
    assert!(report.sliding_m < 0.02, "{report:?}");
    let check = check_clip(clip, &model, &spec, &CheckLimits::default()).expect("the robot");
    assert!(check.measures.joint_range.value < 1e-6 && check.measures.joint_speed.value <= 1.0 + 1e-9);
    assert!(check.measures.floating_m.value < 0.01, "{}", check.measures.floating_m.value);
}

#[test]
fn a_part_is_cut_and_time_is_stretched() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let options = RetargetOptions {
        span_s: [0.5, 1.5],
        time_scale: TimeScale::Fixed(2.0),
        fps: 100.0,
        ..RetargetOptions::default()
    };
    let slow = retarget(&human(), &model, &spec, &options).expect("a human");
    assert_eq!(slow.clip.frames, 201);
    let fast = RetargetOptions { time_scale: TimeScale::Fixed(1.0), ..options };
    let fast = retarget(&human(), &model, &spec, &fast).expect("a human");
    let ratio = fast.report.kick_speed / slow.report.kick_speed;
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

#[test]
fn automatic_slowing_ends_at_the_speed_limits() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let options =
        |time_scale| RetargetOptions { time_scale, speed_share: Some(0.1), ..RetargetOptions::default() };
    let limited = retarget(&human(), &model, &spec, &options(TimeScale::Fixed(1.0))).expect("a human").report;
    assert!(limited.at_speed > 0.0 && limited.joint_speed < 0.1 + 1e-9, "{limited:?}");
    let slow = retarget(&human(), &model, &spec, &options(TimeScale::Auto)).expect("a human").report;
    assert!(slow.time_scale > 1.2 && slow.time_scale < 4.0, "{slow:?}");
    assert!(slow.at_speed == 0.0 && slow.joint_speed < 0.1 + 1e-9, "{slow:?}");
    assert!(slow.position_error_m < limited.position_error_m, "{slow:?} {limited:?}");
}

#[test]
fn options_and_bones_that_make_no_sense_are_refused() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let refusal = |options: RetargetOptions, motion: &HumanMotion| {
        retarget(motion, &model, &spec, &options).expect_err("refused").to_string()
    };
    let motion = human();
    let options = RetargetOptions { span_s: [1.0, 1.01], ..RetargetOptions::default() };
    assert!(refusal(options, &motion).starts_with("part of the motion: expected a part"));
    // Four times as fast there is one frame of it.
    let time_scale = TimeScale::Fixed(0.25);
    let options = RetargetOptions { span_s: [1.0, 1.06], time_scale, ..RetargetOptions::default() };
    assert!(refusal(options, &motion).starts_with("part of the motion: expected a part"));
    let options = RetargetOptions { height_m: f64::NAN, ..RetargetOptions::default() };
    assert!(refusal(options, &motion).starts_with("height of the human: expected 0.5 to 2.5 m, found NaN"));
    let mut other = motion.clone();
    other.skeleton.bones[2].name = "Shin".to_owned();
    let error = refusal(RetargetOptions::default(), &other);
    assert!(
        error.starts_with("kick.bvh: bones named as in LAFAN1: 'LeftLeg' is missing; found: Hips,"),
        "{error}"
    );
}

#[test]
fn a_cleaned_clip_is_compared_with_the_humans_feet_and_hands() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let made = retarget(&human(), &model, &spec, &RetargetOptions::default()).expect("a human");
    let cleaned = clean(&made.clip, &model, &spec, &CleanOptions::default()).expect("a player");
    let human = made.ends.distance(made.clip.fps, &cleaned.clip, &cleaned.report);
    // The way from the human to the clip and on to the cleaned one is no shorter than the direct one.
    let worst = made.report.position_worst_m;
    for (direct, clip) in [(human.feet_m, cleaned.report.feet_m), (human.hands_m, cleaned.report.hands_m)] {
        assert!(direct[1] <= clip[1] + worst + 1e-3 && direct[0] <= direct[1], "{human:?} {worst}");
    }
    // The retargeted clip itself, all of its frames: as near as retargeting brought it.
    let mut whole = cleaned.report.clone();
    (whole.cut, whole.added, whole.slow, whole.floor_m) = ([0, 0], [0, 0], 1.0, 0.0);
    let near = made.ends.distance(made.clip.fps, &made.clip, &whole);
    assert!(near.feet_m[1] <= worst + 1e-9 && near.hands_m[1] <= worst + 1e-9, "{near:?} {worst}");
    // Moved down by a meter, which the report says, it is as near; if it does not say so, a meter off.
    let mut lower = made.clip.clone();
    lower.body_pos.iter_mut().for_each(|p| p[2] -= 1.0);
    assert!((made.ends.distance(lower.fps, &lower, &whole).feet_m[0] - 1.0).abs() < 0.1);
    whole.floor_m = 1.0;
    let same = made.ends.distance(lower.fps, &lower, &whole);
    assert!((same.feet_m[0] - near.feet_m[0]).abs() < 1e-9, "{same:?} {near:?}");
}
