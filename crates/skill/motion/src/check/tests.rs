//! Each fault is found, and nothing else.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec};

use super::*;
use crate::generate::{BuiltinKick, builtin_kicks, generate_kick};
use crate::resample::differentiate;
use crate::{Clip, KickLeg};

fn good() -> Clip {
    let BuiltinKick { request, .. } = builtin_kicks().remove(0);
    generate_kick(&RobotModel::g1(), &RobotSpec::g1(), &request).expect("a kick").clip
}

fn report(clip: &Clip) -> ClipReport {
    check_clip(clip, &RobotModel::g1(), &RobotSpec::g1(), &CheckLimits::default())
        .expect("the built-in robot")
}

/// The aspects that fail or warn.
fn aspects(clip: &Clip) -> Vec<(Aspect, Verdict)> {
    let mut found: Vec<_> = report(clip).findings.iter().map(|f| (f.aspect, f.verdict)).collect();
    found.dedup();
    found
}

/// Every body and the base moved by `shift(time)`.
fn moved(shift: impl Fn(f64) -> [f64; 3]) -> Clip {
    let mut clip = good();
    for t in 0..clip.frames {
        let by = Vec3(shift(t as f64 / clip.fps));
        for p in &mut clip.body_pos[t * clip.bodies..(t + 1) * clip.bodies] {
            *p = (Vec3(*p) + by).0;
        }
    }
    differentiate(&mut clip, &RobotModel::g1());
    clip
}

#[test]
fn a_good_clip_passes() {
    assert_eq!(report(&good()).findings, []);
}

#[test]
fn wrong_labels_and_missing_terms_are_found() {
    let mislabeled = Clip { kick_leg: KickLeg::Left, kick_frame: None, ..good() };
    assert_eq!(aspects(&mislabeled)[0], (Aspect::Label, Verdict::Fail));
    assert_eq!(aspects(&Clip { license: None, ..good() }), [(Aspect::License, Verdict::Warn)]);
    assert_eq!(aspects(&Clip { kick_frame: Some(3), ..good() }), [(Aspect::Label, Verdict::Fail)]);
}

#[test]
fn feet_below_above_and_along_the_floor_are_found() {
    assert_eq!(aspects(&moved(|_| [0.0, 0.0, -0.02])), [(Aspect::Penetration, Verdict::Warn)]);
    assert_eq!(aspects(&moved(|_| [0.0, 0.0, -0.05])), [(Aspect::Penetration, Verdict::Fail)]);
    assert_eq!(aspects(&moved(|_| [0.0, 0.0, 0.05])), [(Aspect::Floating, Verdict::Warn)]);
    assert_eq!(aspects(&moved(|t| [0.08 * t, 0.0, 0.0])), [(Aspect::Sliding, Verdict::Warn)]);
}

#[test]
fn a_jump_of_the_whole_robot_is_found() {
    let found = aspects(&moved(|t| [if t > 2.0 { 0.5 } else { 0.0 }, 0.0, 0.0]));
    assert!(found.contains(&(Aspect::Continuity, Verdict::Fail)), "{found:?}");
}

#[test]
fn joints_out_of_range_too_fast_or_apart_from_the_bodies_are_found() {
    let model = RobotModel::g1();
    let knee = model.joint_index("left_knee_joint").expect("a knee");
    let mut clip = good();
    clip.joint_pos[40 * clip.joints + knee] = 3.0;
    let found = aspects(&clip);
    for aspect in [Aspect::JointLimits, Aspect::JointSpeeds, Aspect::Continuity, Aspect::Kinematics] {
        assert!(found.contains(&(aspect, Verdict::Fail)), "{aspect:?} in {found:?}");
    }
    let mut clip = good();
    clip.joint_vel[50 * clip.joints + knee] += 1.0;
    clip.body_lin_vel[60 * clip.bodies + 3][1] += 4.0;
    let found = report(&clip).findings;
    let places: Vec<_> = found.iter().map(|f| (f.aspect, f.verdict, f.frame)).collect();
    let expected =
        [(Aspect::Velocities, Verdict::Fail, Some(60)), (Aspect::Velocities, Verdict::Warn, Some(50))];
    assert_eq!(places, expected, "{found:?}");
}

#[test]
fn a_kick_to_the_side_and_an_arm_in_the_trunk_are_found() {
    let mut clip = good();
    // The start faces away from where the robot then goes.
    for i in 0..clip.bodies {
        let half = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), std::f64::consts::PI);
        let base = Vec3(clip.body_pos[0]);
        clip.body_pos[i] = (half.rotate(Vec3(clip.body_pos[i]) - base) + base).0;
        clip.body_quat[i] = half.mul(Quat(clip.body_quat[i])).0;
    }
    let found = aspects(&clip);
    assert!(found.contains(&(Aspect::Heading, Verdict::Fail)), "{found:?}");

    let model = RobotModel::g1();
    let (hand, trunk) = (model.body_index("left_wrist_yaw_link"), model.body_index("torso_link"));
    let mut clip = good();
    let at = 30 * clip.bodies;
    clip.body_pos[at + hand.expect("a hand")] = clip.body_pos[at + trunk.expect("a trunk")];
    let found = report(&clip).findings;
    let touch = found.iter().find(|f| f.aspect == Aspect::SelfCollision).expect("found");
    assert!(touch.reason.contains("left_wrist_yaw_link"), "{touch:?}");
}

#[test]
fn a_clip_that_does_not_end_standing_is_warned_of() {
    // Cut off in the approach, the swinging leg in the air.
    let clip = good();
    let frames = clip.kick_frame.expect("stated") + 1;
    let cut = Clip {
        frames,
        kick_frame: None,
        joint_pos: clip.joint_pos[..frames * clip.joints].to_vec(),
        joint_vel: clip.joint_vel[..frames * clip.joints].to_vec(),
        body_pos: clip.body_pos[..frames * clip.bodies].to_vec(),
        body_quat: clip.body_quat[..frames * clip.bodies].to_vec(),
        body_lin_vel: clip.body_lin_vel[..frames * clip.bodies].to_vec(),
        body_ang_vel: clip.body_ang_vel[..frames * clip.bodies].to_vec(),
        ..clip
    };
    let report = report(&cut);
    let reasons: Vec<&str> = report
        .findings
        .iter()
        .filter(|f| f.aspect == Aspect::End && f.verdict == Verdict::Warn)
        .map(|f| f.reason.as_str())
        .collect();
    assert!(reasons.iter().any(|r| r.contains("rad/s at the end: no stand to hold")), "{reasons:?}");
    assert!(reasons.contains(&"ends with 1 of 2 feet on the floor: no stand to hold"), "{reasons:?}");
}

/// The clip `good` through files in a folder, at these rates.
fn folder(rates: &[f64]) -> Vec<ClipReport> {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let folder = tempfile::tempdir().expect("a folder");
    for rate in rates {
        let clip = crate::resample(&good(), &model, *rate);
        let path = folder.path().join(format!("{rate:03}.npz"));
        crate::write_motion(&path, &clip, &model, &spec).expect("written");
    }
    let library = crate::MotionLibrary::load_unchanged(folder.path(), &model, &spec).expect("read");
    library.clips.iter().map(report).collect()
}

#[test]
fn a_folder_of_mixed_frame_rates_is_checked_clip_by_clip_and_the_mixture_is_reported() {
    let reports = folder(&[24.0, 30.0, 50.0, 240.0]);
    assert_eq!(reports.iter().map(|r| r.fps).collect::<Vec<_>>(), [24.0, 30.0, 50.0, 240.0]);
    let rate =
        |r: &ClipReport| r.findings.iter().find(|f| f.aspect == Aspect::Rate).map(|f| f.reason.clone());
    let text = rate(&reports[0]).expect("24 are few");
    assert!(
        text.starts_with("has 24 frames a second, expected 30 or more: at the kick the foot moves ")
            && text.ends_with(" cm from one to the next"),
        "{text}"
    );
    assert_eq!(reports[1..].iter().filter_map(rate).count(), 0);
    assert!(reports.iter().all(|r| r.verdict < Verdict::Fail), "{:?}", reports[3].findings);
    assert_eq!(
        mixed_rates(&reports).expect("mixed"),
        "the clips have 24, 30, 50, 240 frames a second: each was checked at its own; training brings all to its control rate"
    );
    assert_eq!(mixed_rates(&reports[..1]), None);
}

#[test]
fn clips_that_end_away_from_their_ball_are_reported() {
    let mut reports = folder(&[50.0, 60.0]);
    assert_eq!(ends_away(&reports), None, "{:?}", reports[0].measures.end_to_ball_m);
    reports[1].measures.end_to_ball_m = 0.85;
    reports[1].name = "far".to_owned();
    assert_eq!(
        ends_away(&reports).expect("one is"),
        "1 of 2 clips end more than 0.4 m from the ball that the foot strikes ('far': 0.8 m): train Stage II with \
         --set task.ball.own_place=strike"
    );
}

#[test]
fn a_strike_over_the_ball_is_found() {
    let mut clip = good();
    let strike = report(&clip).measures.foot_speed.frame;
    clip.kick_frame = Some(strike);
    let low = report(&clip).measures.strike_height_m;
    assert!((0.0..0.22).contains(&low) && report(&clip).findings.is_empty(), "{low}");
    // The whole robot 0.3 m up.
    let clip = Clip { kick_frame: Some(strike), ..moved(|_| [0.0, 0.0, 0.3]) };
    let high = report(&clip);
    assert!((high.measures.strike_height_m - low - 0.3).abs() < 1e-9);
    let finding = high.findings.iter().find(|f| f.aspect == Aspect::Label).expect("over the ball");
    assert_eq!((finding.verdict, finding.frame), (Verdict::Warn, Some(strike)));
    assert!(finding.reason.ends_with("m above the floor at the strike, over a ball that lies there"));
}

#[test]
fn three_frames_get_a_verdict_that_says_so() {
    let clip = crate::edit::cut(&good(), &RobotModel::g1(), 1.0, 1.04).expect("3 frames");
    let report = report(&clip);
    assert_eq!(report.frames, 3);
    let short = |f: &&Finding| f.reason == "lasts only 0.04 s";
    let found = report.findings.iter().find(short).map(|f| (f.aspect, f.verdict));
    assert_eq!(found, Some((Aspect::Duration, Verdict::Fail)), "{:?}", report.findings);
}

#[test]
fn less_than_half_a_second_fails_and_less_than_a_second_is_warned_of() {
    let length = |to: f64| {
        let clip = crate::edit::cut(&good(), &RobotModel::g1(), 1.0, to).expect("frames");
        let found = report(&clip).findings.into_iter().find(|f| f.aspect == Aspect::Duration);
        found.map(|f| (f.verdict, f.reason))
    };
    assert_eq!(length(1.28), Some((Verdict::Fail, "lasts only 0.28 s".to_owned())));
    assert_eq!(length(1.5), Some((Verdict::Warn, "lasts only 0.50 s".to_owned())));
    assert_eq!(length(2.0), None);
}

/// The stand that `good` begins with, for two seconds, gliding ahead at this speed `[m/s]`.
fn stand(speed: f64) -> Clip {
    let clip = good();
    let first = clip.poses().next().expect("a frame");
    let poses: Vec<_> = (0..100)
        .map(|t| {
            let mut pose = first.clone();
            pose.base_pos[0] += speed * f64::from(t) / 50.0;
            pose
        })
        .collect();
    let still = Clip::of_poses(&RobotModel::g1(), 50.0, &poses);
    Clip { kick_leg: clip.kick_leg, license: clip.license, ..still }
}

#[test]
fn a_clip_without_a_kick_fails_and_has_no_heading() {
    let of = |clip: &Clip| -> Vec<(Verdict, String)> {
        let findings = report(clip).findings.into_iter();
        findings
            .filter(|f| matches!(f.aspect, Aspect::Label | Aspect::Heading))
            .map(|f| (f.verdict, f.reason))
            .collect()
    };
    let none = |speed: &str| {
        let reason = format!("no kick: the foot reaches {speed} m/s, expected 1 or more");
        vec![(Verdict::Fail, reason)]
    };
    assert_eq!(of(&stand(0.0)), none("0.00"));
    assert_eq!(of(&Clip { kick_frame: Some(3), ..stand(0.0) }), none("0.00"), "no frame is the fastest");
    assert_eq!(of(&stand(0.9)), none("0.90"));
    let fast = of(&stand(1.1));
    assert!(!fast.iter().any(|(_, reason)| reason.starts_with("no kick")), "{fast:?}");
}

/// A pickle as GMR writes it, protocol 0, lists: `good`, each base moved to `at(place, quaternion w, x, y, z)`.
fn pickled(at: impl Fn([f64; 3], [f64; 4]) -> ([f64; 3], [f64; 4])) -> Clip {
    let list = |row: &[f64]| row.iter().fold("(l".to_owned(), |text, x| format!("{text}F{x:?}\na"));
    let (mut pos, mut rot, mut dof) = ("(l".to_owned(), "(l".to_owned(), "(l".to_owned());
    let clip = good();
    for t in 0..clip.frames {
        let (p, [w, x, y, z]) = at(clip.body_pos(t)[0], clip.body_quat(t)[0]);
        pos += &format!("{}a", list(&p));
        rot += &format!("{}a", list(&[x, y, z, w]));
        dof += &format!("{}a", list(clip.joint_pos(t)));
    }
    let text = format!("(dVfps\nF{:?}\nsVroot_pos\n{pos}sVroot_rot\n{rot}sVdof_pos\n{dof}s.", clip.fps);
    crate::parse_gmr(
        text.as_bytes(),
        "kick.pkl".as_ref(),
        &RobotModel::g1(),
        &RobotSpec::g1(),
        &crate::ReadOptions::default(),
    )
    .expect("a pickle")
}

#[test]
fn a_pickle_in_centimeters_or_with_y_up_fails_with_a_sentence_that_says_so() {
    let upright = |clip: &Clip| {
        let report = report(clip);
        let found = report.findings.iter().find(|f| f.aspect == Aspect::Upright);
        found.map(|f| (f.verdict, f.reason.clone()))
    };
    assert_eq!(upright(&pickled(|p, q| (p, q))), None, "meters with z up");
    let (verdict, reason) =
        upright(&pickled(|p, q| (p.map(|x| 100.0 * x), q))).expect("centimeters are reported");
    assert_eq!(verdict, Verdict::Fail);
    assert!(
        reason.starts_with("expected a base about 0.") && reason.ends_with(": these look like centimeters"),
        "{reason}"
    );
    // x, y, z of ours is x, z, -y of a file with y up: a turn by -90 degrees about x.
    let turn = Quat::from_axis_angle(Vec3([1.0, 0.0, 0.0]), -std::f64::consts::FRAC_PI_2);
    let y_up = pickled(|p, q| (turn.rotate(Vec3(p)).0, turn.mul(Quat(q)).0));
    let (verdict, reason) = upright(&y_up).expect("another axis is reported");
    assert_eq!(verdict, Verdict::Fail);
    assert!(reason.contains("100 % of the frames: it lies, or another axis points up"), "{reason}");
}
