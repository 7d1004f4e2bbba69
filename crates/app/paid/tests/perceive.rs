//! `paid perceive`: detectors are evaluated, wrong input is refused.

use std::fs;

use crate::common::{paid, refuses, succeeds};
use serde_json::Value;

#[test]
fn the_own_detector_is_judged_and_the_worst_pictures_are_shown() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = paid(folder.path(), &["perceive", "detect", "--held-out", "4", "--json", "--out", "seen"]);
    let report: Value = serde_json::from_str(&succeeds(&output)).expect("JSON");
    assert_eq!(report["pictures"], 8);
    assert_eq!(report["rows"][0]["group"], "all");
    assert!(report["rows"][0]["balls"].as_u64().is_some_and(|n| n <= 4));
    assert!(report["detect_ms"].as_f64().is_some_and(|ms| ms > 0.0));
    let written = fs::read_to_string(folder.path().join("seen/report.json")).expect("the report");
    assert_eq!(serde_json::from_str::<Value>(&written).expect("JSON"), report);
    // No score is so high: all balls are missed, and the sheet shows them.
    let unsure =
        ["perceive", "detect", "--held-out", "2", "--confidence", "0.999999", "--json", "--out", "none"];
    let report: Value = serde_json::from_str(&succeeds(&paid(folder.path(), &unsure))).expect("JSON");
    assert_eq!(report["rows"][0]["found"], 0);
    let sheet = fs::read(folder.path().join("none/worst.png")).expect("the worst images");
    assert!(sheet.starts_with(b"\x89PNG") && sheet.len() > 10_000, "{} bytes", sheet.len());
}

#[test]
fn wrong_detectors_and_options_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    fs::write(folder.path().join("broken.onnx"), b"no model").expect("writes");
    let error = refuses(&paid(folder.path(), &["perceive", "detect", "--detector", "broken.onnx"]));
    assert!(error.contains("broken.onnx"), "{error}");
    let error = refuses(&paid(folder.path(), &["perceive", "detect", "--confidence", "1.5"]));
    assert!(error.contains("--confidence") && error.contains("1.5"), "{error}");
    // The run ends before the fault begins.
    let fault = ["perceive", "odometry", "--scene", "hall", "--seconds", "8", "--fault", "covered"];
    let error = refuses(&paid(folder.path(), &fault));
    assert!(
        error.contains("--seconds: expected 8.1 or more with --fault") && error.contains("found 8"),
        "{error}"
    );
    let error = refuses(&paid(folder.path(), &["perceive", "replay", "a.mcap", "--class", "1"]));
    assert!(error.contains("--detector"), "{error}");
    // What cannot be written is said before the work.
    fs::write(folder.path().join("taken"), b"precious").expect("writes");
    let error = refuses(&paid(folder.path(), &["perceive", "detect", "--held-out", "1", "--out", "taken"]));
    assert!(error.contains("--out: expected a folder, found the file taken"), "{error}");
    let error = refuses(&paid(folder.path(), &["perceive", "detect", "--picture", "640"]));
    assert!(error.contains("640x480"), "{error}");
    #[cfg(not(feature = "train-detector"))]
    {
        let error = refuses(&paid(folder.path(), &["perceive", "train", "--steps", "7"]));
        assert!(error.contains("train-detector") && error.contains("--steps 7"), "{error}");
    }
}

#[test]
fn a_detector_of_the_user_is_told_what_it_was_taken_for() {
    let test = "a_detector_of_the_user_is_told_what_it_was_taken_for";
    let Some(file) = paid_testing::shared_data(test, "cases/names_ball_1.onnx") else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let file = file.to_str().expect("a name");
    let judge = ["perceive", "detect", "--held-out", "1", "--json", "--detector", file];
    let output = paid(folder.path(), &judge);
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    let expected = "taken for YOLOv8 with an input of 320 x 320 pixels; the ball is class 1 of 3, \"ball\"";
    assert!(told.contains(expected), "{told}");
    succeeds(&output);
    let error = refuses(&paid(folder.path(), &[&judge[..], &["--class", "3"]].concat()));
    assert!(error.contains("class: expected 0 to 2, found 3"), "{error}");
}

#[test]
fn a_camera_is_calibrated_from_views_and_too_few_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    // A ball 1.2 m ahead, seen exactly by a camera as described, from a torso that leans about two axes and turns.
    let camera = paid_vision::Pose::g1_camera();
    let views: Vec<Value> = (0..9)
        .map(|k| {
            let angle = |i: i32| 0.3 * f64::from((k + i) % 3 - 1);
            let turn = |axis: [f64; 3], angle: f64| {
                paid_lanes::Quat::<f64>::from_axis_angle(paid_lanes::Vec3(axis), angle)
            };
            let quat = turn([0.0, 0.0, 1.0], angle(k / 3))
                .mul(turn([0.0, 1.0, 0.0], angle(0)))
                .mul(turn([1.0, 0.0, 0.0], angle(k / 2)));
            let torso = paid_vision::Pose { rot: quat.to_mat(), pos: paid_lanes::Vec3([0.0, 0.0, 0.8]) };
            let ball = torso.compose(&camera).inverse_point([1.2, 0.0, 0.11]);
            serde_json::json!({ "place": 0, "torso_m": torso.pos.0, "torso_quat": quat.0, "ball_in_camera_m": ball })
        })
        .collect();
    let file = folder.path().join("views.json");
    fs::write(&file, serde_json::to_string(&views).expect("JSON")).expect("writes");
    let output = paid(folder.path(), &["perceive", "calibrate", "views.json", "--json"]);
    let found: Value = serde_json::from_str(&succeeds(&output)).expect("JSON");
    let number = |key: &str| found[key].as_f64().expect("a number");
    assert!((number("down_deg") - 0.83078_f64.to_degrees()).abs() < 0.01, "{found}");
    assert!(number("moved_m") < 1e-4 && number("residual_along_m") < 1e-5, "{found}");
    fs::write(&file, serde_json::to_string(&views[..3]).expect("JSON")).expect("writes");
    let error = refuses(&paid(folder.path(), &["perceive", "calibrate", "views.json"]));
    assert!(error.contains("views.json") && error.contains("6 views"), "{error}");
}
