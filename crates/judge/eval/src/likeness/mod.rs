//! How much a policy's kicks look like the clips: jerk, joint angles, path of the foot, swing of arms, hips and leg.
//!
//! The clips themselves are the measure: each is compared with the other ones.

mod report;
mod take;

use std::path::Path;

use paid_lanes::stats::mean;
use paid_motion::MotionLibrary;
use paid_play::ReferenceLibrary;
use paid_robot::{RobotModel, RobotSpec};
use paid_task::EnvSample;
use take::{Parts, Take};

use crate::episodes::{Ending, EvalSetup, Observer, run_episodes};
use crate::metrics::shooting::fallen;
use crate::policy::DriverMaker;
use crate::shooting::{ShootingOptions, plan, rules_of, start_of};
use crate::{EvalError, Setting};

pub use report::{Likeness, LikenessReport, table};
pub use take::Swing;

/// A policy is watched until this long after the strike `[s]`.
const AFTER_S: f64 = 0.6;
/// One in this many frames is compared with the clips' frames.
const STRIDE: usize = 2;

/// Plays the shots of `options` and compares the kicks with `clips`, which have the control rate ([`load_clips`]).
///
/// # Errors
/// As [`crate::shooting::evaluate`], or if there are no clips.
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    clips: &ReferenceLibrary,
    name: &str,
    options: &ShootingOptions,
) -> Result<LikenessReport, EvalError> {
    let human = Clips::new(clips, &setup.robot, &setup.spec)?;
    let trials = plan(setup, options)?;
    let starts: Vec<_> = trials.iter().map(start_of).collect();
    let (rules, steps) = rules_of(options, setup.preset.control_dt_s());
    let watches = run_episodes(setup, policy, &starts, rules, steps, |_| Watch {
        take: Take::new(&human.parts, setup.robot.joints.len(), setup.preset.control_dt_s()),
        after: (AFTER_S / setup.preset.control_dt_s()).round() as usize,
        nominal_height_m: setup.spec.nominal_height_m,
    })?;
    let takes: Vec<Take> = watches.into_iter().map(|(_, watch)| watch.take).collect();
    Ok(LikenessReport {
        engine: setup.engine.facts(&setup.preset),
        rows: vec![human.own("the clips"), human.of(name, &takes, &|_| None)],
    })
}

/// The motions of `folder` at the control rate of `setup`; the built-in kicks for an empty path.
///
/// # Errors
/// As [`MotionLibrary::open`], or if they do not fit the robot.
pub fn load_clips(folder: &Path, setup: &EvalSetup) -> Result<ReferenceLibrary, EvalError> {
    let rate_hz = 1.0 / setup.preset.control_dt_s();
    let motions = MotionLibrary::open(folder, &setup.robot, &setup.spec, rate_hz)?;
    Ok(ReferenceLibrary::from_motions(&motions, &setup.robot, &setup.spec)?)
}

/// Compares the clips of `library` with those of `clips`, as [`evaluate`] does a policy's kicks.
///
/// # Errors
/// If there are no clips.
pub fn of_library(
    library: &ReferenceLibrary,
    clips: &ReferenceLibrary,
    (robot, spec): (&RobotModel, &RobotSpec),
    name: &str,
) -> Result<[Likeness; 2], EvalError> {
    let human = Clips::new(clips, robot, spec)?;
    Ok([human.own("the clips"), human.of(name, &takes_of(library), &|_| None)])
}

fn takes_of(library: &ReferenceLibrary) -> Vec<Take> {
    library.clips().iter().zip(library.facts()).map(|(clip, facts)| Take::of_clip(clip, facts)).collect()
}

/// What kicks are compared with.
struct Clips {
    parts: Parts,
    takes: Vec<Take>,
    /// Mean jerk of the clips.
    jerk: f64,
}

impl Clips {
    fn new(clips: &ReferenceLibrary, robot: &RobotModel, spec: &RobotSpec) -> Result<Self, EvalError> {
        if clips.is_standing() {
            return Err(EvalError::Option {
                option: Setting::Named("clips"),
                expected: "a folder of motions to compare with, for a policy without a reference".to_owned(),
                found: "none".to_owned(),
            });
        }
        let parts = Parts::of(robot, spec);
        let takes = takes_of(clips);
        let jerk = mean(takes.iter().map(|take| take.jerk(&parts))).unwrap_or(0.0);
        Ok(Self { parts, takes, jerk })
    }

    /// The clips, each compared with the others.
    fn own(&self, name: &str) -> Likeness {
        self.of(name, &self.takes, &Some)
    }

    /// The means over `takes`. `without` says which clip a take is not compared with.
    fn of(&self, name: &str, takes: &[Take], without: &dyn Fn(usize) -> Option<usize>) -> Likeness {
        let parts = &self.parts;
        let jerk = mean(takes.iter().filter(|take| take.frames() > 3).map(|take| take.jerk(parts)));
        let swings: Vec<Swing> = takes.iter().filter_map(|take| take.swing(parts)).collect();
        let of = |what: fn(&Swing) -> f64| mean(swings.iter().map(what));
        let others = |k: usize| {
            let out = without(k);
            self.takes.iter().enumerate().filter(move |(c, _)| Some(*c) != out).map(|(_, take)| take)
        };
        let each = |distance: &dyn Fn(&Take, &[&Take]) -> Option<f64>| {
            mean(takes.iter().enumerate().filter_map(|(k, take)| {
                let others: Vec<&Take> = others(k).collect();
                distance(take, &others)
            }))
        };
        Likeness {
            name: name.to_owned(),
            takes: takes.len(),
            kicks: takes.iter().all(|take| take.ball).then_some(swings.len()),
            jerk,
            auj: jerk.map(|jerk| (jerk - self.jerk).abs()),
            joint_distance_deg: each(&|take, others| joint_distance(take, others).map(f64::to_degrees)),
            foot_path_m: each(&|take, others| foot_distance(take, others, parts)),
            swing: of(|s| s.back_swing_m).zip(of(|s| s.hand_swing_m)).zip(of(|s| s.hip_turn_deg)).map(
                |((back_swing_m, hand_swing_m), hip_turn_deg)| Swing {
                    back_swing_m,
                    hand_swing_m,
                    hip_turn_deg,
                },
            ),
        }
    }
}

/// Mean over the frames of the RMS difference of the joint angles to the nearest frame of any of `others` `[rad]`.
fn joint_distance(take: &Take, others: &[&Take]) -> Option<f64> {
    mean((0..take.frames()).step_by(STRIDE).filter_map(|t| {
        let mine = take.joints(t);
        let frames = others.iter().flat_map(|other| (0..other.frames()).map(|u| other.joints(u)));
        let squares = frames.map(|theirs| mine.iter().zip(theirs).map(|(a, b)| (a - b) * (a - b)).sum());
        let least: Option<f64> = squares.min_by(f64::total_cmp);
        least.map(|sum| (sum / mine.len().max(1) as f64).sqrt())
    }))
}

/// Mean distance of the kicking foot's path to that of the nearest of `others` with the same foot, over the frames that both have `[m]`.
fn foot_distance(take: &Take, others: &[&Take], parts: &Parts) -> Option<f64> {
    let (foot, path) = take.foot_path(parts)?;
    let of = |other: &&Take| {
        let (_, theirs) = other.foot_path(parts).filter(|(other, _)| *other == foot)?;
        mean(path.iter().zip(&theirs).filter_map(|(a, b)| {
            let squares = (*a)?.into_iter().zip((*b)?).map(|(x, y)| (x - y) * (x - y));
            Some(squares.sum::<f64>().sqrt())
        }))
    };
    others.iter().filter_map(of).min_by(f64::total_cmp)
}

/// Keeps what one shot shows, until a while after the strike or a fall.
struct Watch {
    take: Take,
    after: usize,
    nominal_height_m: f64,
}

impl Observer for Watch {
    fn observe(&mut self, sample: &EnvSample, _: Option<Ending>) -> bool {
        self.take.push(sample);
        let now = self.take.frames() - 1;
        if let (Some(kick), None) = (&sample.kick, self.take.strike) {
            self.take.strike = Some((now, kick.foot));
        }
        let base = &sample.bodies[0];
        let done = self.take.strike.is_some_and(|(strike, _)| now >= strike + self.after);
        done || fallen(base.pos[2] - sample.ground_m, base.rot[2][2], self.nominal_height_m)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use take::tests::{parts, take};

    fn clips() -> Clips {
        let takes = vec![take(), take()];
        let jerk = takes[0].jerk(&parts());
        Clips { parts: parts(), takes, jerk }
    }

    #[test]
    fn equal_clips_are_no_distance_apart() {
        let own = clips().own("the clips");
        assert_eq!((own.takes, own.kicks, own.auj), (2, Some(2), Some(0.0)));
        assert_eq!((own.joint_distance_deg, own.foot_path_m), (Some(0.0), Some(0.0)));
    }

    #[test]
    fn whether_a_clip_met_a_ball_is_not_told() {
        let mut missed = take();
        missed.strike = None;
        let mut clip = take();
        clip.ball = false;
        let rows =
            [clips().of("played", &[take(), missed], &|_| None), clips().of("clips", &[clip], &|_| None)];
        assert_eq!(rows.each_ref().map(|row| row.kicks), [Some(1), None]);
        assert!(rows[1].swing.is_some(), "it swings all the same");
        let text = table(&rows).to_string();
        let cells: Vec<Vec<&str>> = text.lines().skip(1).map(|l| l.split_whitespace().collect()).collect();
        assert_eq!((&cells[0][1..4], cells[1][1]), (&["1", "of", "2"][..], "-"));
    }

    #[test]
    fn distances_are_those_of_the_nearest_frame_and_path() {
        let mut moved = take();
        // One joint: 0.5 rad beyond the clips' end is 0.5 rad from their last frame, and less from nothing.
        moved.shift_joints(1.5);
        moved.shift_bodies(2, [0.0, 0.0, 0.25]);
        let row = clips().of("moved", &[moved], &|_| None);
        let nearest = (0..60).step_by(2).map(|t| 0.5 + f64::from(t).min(50.0) / 50.0).sum::<f64>() / 30.0;
        assert!((row.joint_distance_deg.expect("frames") - nearest.to_degrees()).abs() < 1e-9);
        assert!((row.foot_path_m.expect("a path") - 0.25).abs() < 1e-12);
        // The other foot has no clip.
        let mut left = take();
        left.strike = Some((50, 0));
        assert_eq!(clips().of("left", &[left], &|_| None).foot_path_m, None);
    }
}
