//! From measures to a verdict.

use std::fmt;

use paid_robot::{RobotModel, RobotSpec, SpecError};
use serde::Serialize;

use super::{CheckLimits, Limit, Measures, Worst, measure};
use crate::implausible::Implausible;
use crate::{Clip, KickLeg};

/// How fit a clip is; the worse is the greater.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Nothing to complain of.
    Pass,
    /// Usable; a policy or a reader may trip over it.
    Warn,
    /// Not to be trained on.
    Fail,
}

impl fmt::Display for Verdict {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Pass => "pass",
            Self::Warn => "warn",
            Self::Fail => "fail",
        })
    }
}

/// What is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Aspect {
    /// A robot on its feet, lengths in meters, z up.
    Upright,
    /// Enough frames to see the kick.
    Rate,
    /// Length of the clip.
    Duration,
    /// The labeled foot is the one that kicks, in the stated frame.
    Label,
    /// The kick is straight ahead.
    Heading,
    /// Terms of use are stated.
    License,
    /// Bodies and joints agree.
    Kinematics,
    /// Stored velocities are those of the motion.
    Velocities,
    /// Joint angles within their ranges.
    JointLimits,
    /// Joint speeds within their limits.
    JointSpeeds,
    /// No jumps from frame to frame.
    Continuity,
    /// Nothing below the floor.
    Penetration,
    /// Something on the floor.
    Floating,
    /// Standing feet stay where they are.
    Sliding,
    /// No part in another.
    SelfCollision,
    /// Pressure within the soles, friction enough.
    Balance,
    /// The last frame is a stand that can be held.
    End,
}

/// Something found.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Finding {
    /// Of which aspect.
    pub aspect: Aspect,
    /// How bad.
    pub verdict: Verdict,
    /// The worst frame, if it belongs to one.
    pub frame: Option<usize>,
    /// One plain sentence.
    pub reason: String,
}

/// The check of a clip.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipReport {
    /// Name.
    pub name: String,
    /// File.
    pub path: String,
    /// Label.
    pub kick_leg: KickLeg,
    /// Number of frames.
    pub frames: usize,
    /// Frames a second, as the file has them.
    pub fps: f64,
    /// Terms of use.
    pub license: Option<String>,
    /// That of the worst finding.
    pub verdict: Verdict,
    /// Worst first.
    pub findings: Vec<Finding>,
    /// The numbers.
    pub measures: Measures,
}

/// Checks a clip.
///
/// # Errors
/// If the robot's TOML names what its MJCF lacks.
pub fn check_clip(
    clip: &Clip,
    model: &RobotModel,
    spec: &RobotSpec,
    limits: &CheckLimits,
) -> Result<ClipReport, SpecError> {
    let measures = measure(clip, model, spec)?;
    let mut findings = findings(clip, &measures, limits);
    if let Some(what) = Implausible::of(clip, model, spec) {
        let (aspect, verdict) = (Aspect::Upright, Verdict::Fail);
        findings.push(Finding { aspect, verdict, frame: None, reason: what.to_string() });
    }
    findings.sort_by_key(|f| (std::cmp::Reverse(f.verdict), f.aspect));
    Ok(ClipReport {
        name: clip.name.clone(),
        path: clip.path.display().to_string(),
        kick_leg: clip.kick_leg,
        frames: clip.frames,
        fps: clip.fps,
        license: clip.license.clone(),
        verdict: findings.first().map_or(Verdict::Pass, |f| f.verdict),
        findings,
        measures,
    })
}

/// A sentence on the clips that fail the check, for a user who is about to use them; `None` if none fails.
///
/// # Errors
/// As [`check_clip`].
pub fn doubts(clips: &[Clip], model: &RobotModel, spec: &RobotSpec) -> Result<Option<String>, SpecError> {
    let limits = CheckLimits::default();
    let mut fails = Vec::new();
    for clip in clips {
        let report = check_clip(clip, model, spec, &limits)?;
        if report.verdict == Verdict::Fail {
            fails.push(format!("{}: {}", report.name, report.findings[0].reason));
        }
    }
    let Some(first) = fails.first() else { return Ok(None) };
    let (failed, all) = (fails.len(), clips.len());
    Ok(Some(format!("{failed} of {all} clips fail `paid motion check`, such as {first}")))
}

/// The verdict on a value; what is not a number fails.
fn judge(value: f64, limit: Limit) -> Verdict {
    if value <= limit.warn {
        Verdict::Pass
    } else if value <= limit.fail {
        Verdict::Warn
    } else {
        Verdict::Fail
    }
}

struct Findings(Vec<Finding>);

impl Findings {
    fn add(&mut self, aspect: Aspect, verdict: Verdict, frame: Option<usize>, reason: String) {
        if verdict > Verdict::Pass {
            self.0.push(Finding { aspect, verdict, frame, reason });
        }
    }
    fn worst(
        &mut self,
        aspect: Aspect,
        worst: &Worst,
        limit: Limit,
        reason: impl FnOnce(f64, &str) -> String,
    ) {
        let reason = reason(worst.value, &worst.part);
        self.add(aspect, judge(worst.value, limit), Some(worst.frame), reason);
    }
}

fn findings(clip: &Clip, m: &Measures, limits: &CheckLimits) -> Vec<Finding> {
    let mut out = Findings(Vec::new());
    let time = judge(m.duration_s, limits.duration_s);
    out.add(Aspect::Duration, time, None, format!("lasts {:.2} s", m.duration_s));
    if m.duration_s < limits.shortest_s {
        let verdict = if m.duration_s < limits.least_s { Verdict::Fail } else { Verdict::Warn };
        out.add(Aspect::Duration, verdict, None, format!("lasts only {:.2} s", m.duration_s));
    }
    if clip.fps < limits.least_fps {
        let reason = format!(
            "has {} frames a second, expected {} or more: at the kick the foot moves {:.0} cm from one to the next",
            per_second(clip.fps),
            limits.least_fps,
            1e2 * m.foot_speed.value / clip.fps
        );
        out.add(Aspect::Rate, Verdict::Warn, None, reason);
    }
    kick(clip, m, limits, &mut out);
    let reason = format!("ends {:.0} degrees off its first heading", m.turn.to_degrees());
    out.add(Aspect::Heading, judge(m.turn, limits.heading), Some(clip.frames - 1), reason);
    if clip.license.is_none() {
        out.add(Aspect::License, Verdict::Warn, None, "states no license".to_owned());
    }
    out.worst(Aspect::Kinematics, &m.kinematics_m, limits.kinematics_m, |v, part| {
        format!("{part} is stored {:.1} mm from where the joints put it", 1e3 * v)
    });
    out.worst(Aspect::Velocities, &m.joint_rate, limits.joint_rate, |v, part| {
        format!("the stored velocity of {part} is {v:.2} rad/s off")
    });
    out.worst(Aspect::Velocities, &m.body_rate, limits.body_rate, |v, part| {
        format!("the stored velocity of {part} is {v:.2} m/s off")
    });
    out.worst(Aspect::JointLimits, &m.joint_range, limits.joint_range, |v, part| {
        format!("{part} is {v:.3} rad beyond its range")
    });
    out.worst(Aspect::JointSpeeds, &m.joint_speed, limits.joint_speed, |v, part| {
        format!("{part} turns at {:.0} % of its speed limit", 100.0 * v)
    });
    out.worst(Aspect::Continuity, &m.joint_jump, limits.joint_jump, |v, part| {
        format!("the velocity of {part} jumps by {:.0} % of its limit in a frame", 100.0 * v)
    });
    out.worst(Aspect::Continuity, &m.base_speed, limits.base_speed, |v, part| {
        format!("{part} moves at {v:.1} m/s")
    });
    out.worst(Aspect::Penetration, &m.penetration_m, limits.penetration_m, |v, _| {
        format!("reaches {:.0} mm below the floor", 1e3 * v)
    });
    out.worst(Aspect::Floating, &m.floating_m, limits.floating_m, |v, _| {
        format!("floats {:.0} mm above the floor", 1e3 * v)
    });
    out.worst(Aspect::Sliding, &m.sliding_m, limits.sliding_m, |v, part| {
        format!("{part} slides {:.0} mm while it stands", 1e3 * v)
    });
    out.worst(Aspect::SelfCollision, &m.overlap_m, limits.overlap_m, |v, part| {
        format!("{part} are {:.0} mm in each other", 1e3 * v)
    });
    let reason =
        format!("the pressure is outside of the soles in {:.0} % of the frames", 100.0 * m.unbalanced);
    out.add(Aspect::Balance, judge(m.unbalanced, limits.unbalanced), None, reason);
    let reason = format!("needs much friction in {:.0} % of the frames", 100.0 * m.slippery);
    out.add(Aspect::Balance, judge(m.slippery, limits.slippery), None, reason);
    end(clip, m, limits, &mut out);
    out.0
}

/// A frame rate with at most two decimals.
fn per_second(fps: f64) -> f64 {
    (1e2 * fps).round() / 1e2
}

/// A sentence if clips have different frame rates: none is wrong, but the user should know that they are resampled.
pub fn mixed_rates(reports: &[ClipReport]) -> Option<String> {
    let mut rates: Vec<f64> = reports.iter().map(|r| per_second(r.fps)).collect();
    rates.sort_by(f64::total_cmp);
    rates.dedup();
    (rates.len() > 1).then(|| {
        let list = rates.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
        format!(
            "the clips have {list} frames a second: each was checked at its own; training brings all to its control rate"
        )
    })
}

/// From here on a torso's end is not where the ball was: the paper's kicks end within 0.3 m of it `[m]`.
const AWAY_M: f64 = 0.4;

/// A note where clips end away from the ball that they strike.
pub fn ends_away(reports: &[ClipReport]) -> Option<String> {
    let away = |report: &&ClipReport| report.measures.end_to_ball_m > AWAY_M;
    let farthest =
        |a: &ClipReport, b: &ClipReport| a.measures.end_to_ball_m.total_cmp(&b.measures.end_to_ball_m);
    let worst = reports.iter().max_by(|a, b| farthest(a, b)).filter(away)?;
    Some(format!(
        "{} of {} clips end more than {AWAY_M} m from the ball that the foot strikes ('{}': {:.1} m): train Stage II with \
         --set task.ball.own_place=strike",
        reports.iter().filter(away).count(),
        reports.len(),
        worst.name,
        worst.measures.end_to_ball_m
    ))
}

/// A last frame that is no stand.
fn end(clip: &Clip, m: &Measures, limits: &CheckLimits, out: &mut Findings) {
    let last = Some(clip.frames - 1);
    out.worst(Aspect::End, &m.end_joint_speed, limits.end_joint_speed, |v, part| {
        format!("{part} still turns at {v:.2} rad/s at the end: no stand to hold")
    });
    let reason = format!("the base still moves at {:.2} m/s at the end: no stand to hold", m.end_base_speed);
    out.add(Aspect::End, judge(m.end_base_speed, limits.end_base_speed), last, reason);
    let reason = format!("ends {:.0} degrees off upright: no stand to hold", m.end_tilt.to_degrees());
    out.add(Aspect::End, judge(m.end_tilt, limits.end_tilt), last, reason);
    if m.end_feet < 2 {
        let reason = format!("ends with {} of 2 feet on the floor: no stand to hold", m.end_feet);
        out.add(Aspect::End, Verdict::Warn, last, reason);
    }
}

/// Whether there is a kick, with which foot, when and whereto. Of a foot that rests, frame and heading are noise.
fn kick(clip: &Clip, m: &Measures, limits: &CheckLimits, out: &mut Findings) {
    let [labeled, other] = [&m.foot_speed, &m.other_foot_speed].map(|w| w.value < limits.least_foot_speed);
    if labeled && other {
        let reason = format!(
            "no kick: the foot reaches {:.2} m/s, expected {} or more",
            m.foot_speed.value, limits.least_foot_speed
        );
        out.add(Aspect::Label, Verdict::Fail, Some(m.foot_speed.frame), reason);
    } else {
        label(clip, m, limits, out);
    }
    if !labeled {
        let reason = format!("kicks {:.0} degrees off its first heading", m.shot_angle.to_degrees());
        out.add(Aspect::Heading, judge(m.shot_angle, limits.heading), Some(m.foot_speed.frame), reason);
    }
}

fn label(clip: &Clip, m: &Measures, limits: &CheckLimits, out: &mut Findings) {
    let fastest = &m.foot_speed;
    if m.other_foot_speed.value > fastest.value {
        let reason = format!(
            "labeled {}, but the other foot is faster ({:.1} m/s against {:.1})",
            clip.kick_leg, m.other_foot_speed.value, fastest.value
        );
        out.add(Aspect::Label, Verdict::Fail, Some(m.other_foot_speed.frame), reason);
    }
    if let Some(stated) = clip.kick_frame {
        let off = stated.abs_diff(fastest.frame) as f64 / clip.fps;
        let reason = format!("kick frame {stated}, but the foot is fastest in frame {}", fastest.frame);
        out.add(Aspect::Label, judge(off, limits.kick_frame_s), Some(stated), reason);
    }
    let reason = format!(
        "the foot is {:.2} m above the floor at the strike, over a ball that lies there",
        m.strike_height_m
    );
    let strike = clip.kick_frame.unwrap_or(fastest.frame);
    out.add(Aspect::Label, judge(m.strike_height_m, limits.strike_height_m), Some(strike), reason);
}
