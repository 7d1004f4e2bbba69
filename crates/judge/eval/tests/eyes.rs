//! Shots with onboard perception from end to end, as `paid eval shooting --eyes` plays them: the committed demo policy on its own kicks in
//! MuJoCo, rendered images, the built-in network, LiDAR odometry. No recorded motion is needed.

use std::path::Path;

use paid_eval::eyes::{self, Cause, EyesOptions, EyesOutcome, EyesReport};
use paid_eval::monitor::{Effort, Timing};
use paid_eval::results::{Evaluation, to_json, write_eyes};
use paid_eval::scene::Engines;
use paid_eval::shooting::{Grid, ShootingOptions};
use paid_eval::subject::{Subject, SubjectSpec};
use paid_mujoco::Library;

/// How far from its place a ball may be believed when the motion is chosen `[m]`; 0.9 cm is the mean of 43 balls in view.
const START_ERROR_M: f64 = 0.04;
/// What odometry may have drifted since the last image `[m]`; the mean is 1.1 cm.
const ODOMETRY_ERROR_M: f64 = 0.05;

/// The demo in MuJoCo, or `None` (the test is skipped) without it.
fn demo(test: &str, threads: usize) -> Option<Subject> {
    paid_testing::mujoco(test, Library::get())?;
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    let spec = SubjectSpec { engines: Engines::Mujoco, threads, ..SubjectSpec::new(policy) };
    Some(Subject::load(&spec).expect("the demo"))
}

/// Balls at rest 1 m and 1.5 m ahead of a robot that is not displaced: in the image while it waits.
fn shots() -> ShootingOptions {
    ShootingOptions {
        grid: Grid { x: [1.0, 1.5], y: [0.0, 0.0], step: 0.5 },
        trials: 1,
        start_radius_m: 0.0,
        ..ShootingOptions::default()
    }
}

/// What was seen, without what the machine took for it.
fn without_clocks(report: &EyesReport) -> Vec<EyesOutcome> {
    let still =
        |eyes: &EyesOutcome| EyesOutcome { sensors_cpu_s: 0.0, sight_cpu_s: 0.0, cpu_s: 0.0, ..eyes.clone() };
    report.seen.iter().map(still).collect()
}

// Slow: plays two shots twice with every image and scan, because two threads and one must give the same bits.
#[test]
fn balls_in_view_are_seen_believed_and_kicked_into_the_goal_and_the_seed_repeats_it() {
    let test = "balls_in_view_are_seen_believed_and_kicked_into_the_goal_and_the_seed_repeats_it";
    let Some(subject) = demo(test, 2) else { return };
    let eyes = EyesOptions { log: Some(1), ..EyesOptions::default() };
    let (report, kick) = eyes::evaluate(&subject.setup, &*subject.maker, &shots(), &eyes).expect("plays");
    println!("{}", report.table());
    assert_eq!((report.shooting.trials.len(), report.seen.len()), (2, 2));
    assert_eq!((report.in_view.success.trials, report.out_of_view.success.trials), (2, 0));
    for seen in &report.seen {
        assert!(seen.start_error_m.is_some_and(|error| error < START_ERROR_M), "{seen:?}");
        assert!(seen.odometry_error_m.is_some_and(|error| error < ODOMETRY_ERROR_M), "{seen:?}");
        assert!(seen.with_ball > 20 && seen.found * 10 >= seen.with_ball * 9, "{seen:?}");
        assert!(seen.false_finds <= 1 && seen.untracked_steps == 0, "{seen:?}");
        assert!(seen.sightings.iter().filter(|s| s.own).count() > 20);
    }
    // Each of 43 such balls went in when it was measured; one may be missed here.
    let causes: Vec<_> = report.seen.iter().map(|seen| seen.cause).collect();
    assert!(report.in_view.success.count >= 1, "{causes:?}");
    assert_eq!(causes.iter().filter(|cause| cause.is_none()).count(), report.in_view.success.count);

    let folder = tempfile::tempdir().expect("a folder");
    let json = to_json(&Evaluation::new("eyes", &subject.name, &report, Timing::of(Effort::default(), 1.0)))
        .expect("JSON");
    write_eyes(folder.path(), &report, kick.as_ref(), &json).expect("writes");
    let files = [
        "eyes_static_shooting.json",
        "eyes_static_trials.csv",
        "eyes_static.txt",
        "eyes_static_sightings.csv",
        "eyes_static_kick.svg",
    ];
    for name in files {
        let written = std::fs::metadata(folder.path().join(name));
        assert!(written.is_ok_and(|file| file.len() > 100), "{name}");
    }
    let finds: usize = report.seen.iter().map(|seen| seen.sightings.len()).sum();
    let csv =
        std::fs::read_to_string(folder.path().join("eyes_static_sightings.csv")).expect("the detections");
    assert_eq!(csv.lines().count(), 1 + finds);

    // The same seed on one thread: the same, to the last bit.
    let Some(again) = demo(test, 1) else { return };
    let (repeated, _) = eyes::evaluate(&again.setup, &*again.maker, &shots(), &eyes).expect("plays again");
    assert_eq!(without_clocks(&report), without_clocks(&repeated));
    assert_eq!(report.shooting, repeated.shooting);
}

#[test]
fn a_robot_that_finds_nothing_does_not_kick_and_the_cause_is_not_seen() {
    let test = "a_robot_that_finds_nothing_does_not_kick_and_the_cause_is_not_seen";
    let Some(subject) = demo(test, 2) else { return };
    // No detection has such a score: as if the camera was covered.
    let eyes = EyesOptions { confidence: Some(1.0), points_per_s: 20_000.0, ..EyesOptions::default() };
    let (report, kick) = eyes::evaluate(&subject.setup, &*subject.maker, &shots(), &eyes).expect("plays");
    assert!(kick.is_none());
    assert_eq!((report.in_view.success.count, report.in_view.causes), (0, [2, 0, 0, 0]));
    for (seen, shot) in report.seen.iter().zip(&report.shooting.trials) {
        assert_eq!((seen.cause, seen.start_error_m, seen.found), (Some(Cause::NotSeen), None, 0), "{seen:?}");
        assert!(seen.with_ball > 10 && !shot.goal, "the ball was in the images: {seen:?}");
    }
}
