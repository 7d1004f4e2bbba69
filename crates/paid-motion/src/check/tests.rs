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
