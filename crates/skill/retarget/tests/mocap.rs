//! Real human kicks: CMU Graphics Lab Motion Capture Database (mocap.cs.cmu.edu, NSF EIA-0196217) and
//! Bandai-Namco-Research-Motiondataset. The files are not in the repository: without the shared data the tests are skipped.

use std::path::PathBuf;

use paid_motion::KickLeg;
use paid_retarget::{HumanOptions, RetargetOptions, SolveLimits, TimeScale, read_human, retarget};
use paid_robot::{RobotModel, RobotSpec};

/// A file of the human motions, or `None` (the test is skipped).
fn mocap(test: &str, file: &str) -> Option<PathBuf> {
    paid_testing::shared_data(test, &format!("data/mocap/{file}"))
}

const KICKS: [&str; 7] = [
    "cmu/10_01.amc",
    "cmu/10_02.amc",
    "cmu/10_03.amc",
    "cmu/10_05.amc",
    "cmu/10_06.amc",
    "cmu/11_01.amc",
    "bandai/dataset-1_kick_normal_001.bvh",
];

#[test]
fn every_human_kick_becomes_a_robots_kick() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    for file in KICKS {
        let Some(path) = mocap("every_human_kick_becomes_a_robots_kick", file) else { return };
        let motion = read_human(&path, &HumanOptions::default()).expect(file);
        let report = retarget(&motion, &model, &spec, &RetargetOptions::default()).expect(file);
        let (clip, report) = (report.clip, report.report);
        assert_eq!(clip.kick_leg, KickLeg::Right, "{file}");
        assert!((6.0..14.0).contains(&report.kick_speed), "{file}: {report:?}");
        assert!(report.at_range < 0.03 && report.joint_speed < 1.0 + 1e-9, "{file}: {report:?}");
        assert!(report.position_error_m < 0.1 && report.rotation_error < 0.25, "{file}: {report:?}");
        // The torso stays above the feet: the robot walks upright.
        let torso = model.body_index("torso_link").expect("a torso");
        assert!((0..clip.frames).all(|t| clip.body_pos(t)[torso][2] > 0.5), "{file}");
    }
}

#[test]
fn the_fast_solver_is_as_near_as_one_run_to_convergence() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    for file in KICKS {
        let Some(path) = mocap("the_fast_solver_is_as_near_as_one_run_to_convergence", file) else { return };
        let motion = read_human(&path, &HumanOptions::default()).expect(file);
        let fast = retarget(&motion, &model, &spec, &RetargetOptions::default()).expect(file);
        let thorough = RetargetOptions {
            limits: SolveLimits { steps: 1000, share: 1e-10 },
            ..RetargetOptions::default()
        };
        let slow = retarget(&motion, &model, &spec, &thorough).expect(file);
        // A solve that ends early shows in a single frame only, as a knee that jumps: by 0.35 rad in frame 139 of 10_01, once.
        let apart: Vec<usize> = (0..fast.clip.frames)
            .filter(|&t| {
                let pairs = fast.clip.joint_pos(t).iter().zip(slow.clip.joint_pos(t));
                pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) > 0.1
            })
            .collect();
        let (fast, slow) = (fast.report, slow.report);
        println!(
            "{file}: {:.3} mm in {:.1} solves a frame, {:.3} mm in {:.1}, frames apart {apart:?}",
            1e3 * fast.position_error_m,
            fast.steps[1],
            1e3 * slow.position_error_m,
            slow.steps[1]
        );
        assert!(apart.is_empty(), "{file}: {apart:?}");
        assert!(slow.steps[1] > 1.5 * fast.steps[1], "{file}: the reference works harder");
        assert!(fast.position_error_m < slow.position_error_m + 2e-4, "{file}: {fast:?} {slow:?}");
    }
}

#[test]
fn a_kick_that_is_too_fast_can_be_slowed_down() {
    let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
    let Some(path) = mocap("a_kick_that_is_too_fast_can_be_slowed_down", "cmu/11_01.amc") else { return };
    let motion = read_human(&path, &HumanOptions::default()).expect("reads");
    let options =
        RetargetOptions { time_scale: TimeScale::Auto, speed_share: Some(0.5), ..RetargetOptions::default() };
    let report = retarget(&motion, &model, &spec, &options).expect("a kick").report;
    assert!(report.time_scale > 1.0 && report.at_speed < 1e-3, "{report:?}");
    assert!(report.joint_speed <= 0.5 + 1e-9, "{report:?}");
}

#[test]
fn the_skeleton_of_an_amc_is_found_or_asked_for() {
    let Some(path) = mocap("the_skeleton_of_an_amc_is_found_or_asked_for", "cmu/10_01.amc") else { return };
    let folder = tempfile::tempdir().expect("a temporary folder");
    let alone = folder.path().join("10_01.amc");
    std::fs::copy(&path, &alone).expect("copies");
    let error = read_human(&alone, &HumanOptions::default()).expect_err("no skeleton").to_string();
    assert!(
        error.contains("expected the skeleton of this motion (.asf of an .amc")
            && error.ends_with("found none"),
        "{error}"
    );
    let asf = path.with_file_name("10.asf");
    let options = HumanOptions { skeleton: Some(asf), ..HumanOptions::default() };
    assert!(read_human(&alone, &options).is_ok());
}
