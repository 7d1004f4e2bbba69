//! `paid eval` on policies that are not this project's: the released interface, and the TWIST2 tracker.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{folder, paid, refuses, succeeds};
use paid_mujoco::Library;
use paid_onnx::PRESET_KEY;
use paid_onnx::proto::ModelProto;
use prost::Message;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text.trim()).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Mean MPJPE of the exact starts [mm].
fn mpjpe(folder: &Path, policy: &str) -> f64 {
    let args = ["eval", "tracking", "--policy", policy, "--motions", "motions", "--starts", "0", "--json"];
    let report = json(&succeeds(&paid(folder, &args)));
    report["sets"][0]["exact"]["errors"]["mpjpe_mm"].as_f64().expect("a number")
}

#[test]
fn a_file_with_the_released_interface_brings_its_own_gains() {
    let folder = folder();
    let bytes = fs::read(folder.path().join("run/policy.onnx")).expect("the export");
    // The same network without this project's entries is a file with the released interface alone.
    let released = |name: &str, change: &dyn Fn(&mut ModelProto)| {
        let mut model = ModelProto::decode(&bytes[..]).expect("ONNX");
        model.metadata_props.retain(|e| !e.key.as_deref().is_some_and(|key| key.starts_with("paid_")));
        change(&mut model);
        fs::write(folder.path().join(name), model.encode_to_vec()).expect("writes");
    };
    released("same.onnx", &|_| {});
    // As files of the first format were: without a preset, so that the ONNX runtime plays it too.
    let mut first = ModelProto::decode(&bytes[..]).expect("ONNX");
    first.metadata_props.retain(|e| e.key.as_deref() != Some(PRESET_KEY));
    fs::write(folder.path().join("first.onnx"), first.encode_to_vec()).expect("writes");
    let own = mpjpe(folder.path(), "first.onnx");
    let same = mpjpe(folder.path(), "same.onnx");
    assert!((same - own).abs() < 1e-6 * own, "{same} and {own}");
    // Joints of a tenth of the stiffness give way.
    released("weak.onnx", &|model| {
        let mut entries = model.metadata_props.iter_mut();
        let entry = entries.find(|e| e.key.as_deref() == Some("joint_stiffness")).expect("stiffness");
        let gains = entry.value.as_deref().expect("numbers").split(',');
        let weak: Vec<String> =
            gains.map(|g| (0.1 * g.trim().parse::<f64>().expect("a number")).to_string()).collect();
        entry.value = Some(weak.join(","));
    });
    let weak = mpjpe(folder.path(), "weak.onnx");
    assert!((weak - own).abs() > 0.05 * own, "other gains must act in the built-in engine: {weak} and {own}");
    released("short.onnx", &|model| model.metadata_props.retain(|e| e.key.as_deref() != Some("body_names")));
    let args = ["eval", "tracking", "--policy", "short.onnx", "--motions", "motions"];
    let error = refuses(&paid(folder.path(), &args));
    assert!(error.contains("short.onnx") && error.contains("body_names"), "{error}");
}

/// The shared data's folder, or `None` (the test is skipped).
fn shared(test: &str) -> Option<PathBuf> {
    paid_testing::shared_data(test, "data/peers/twist2")?;
    paid_testing::shared_data(test, "data")
}

/// An independent measurement in MuJoCo gave these: MPJPE, G-MPJPE [mm], velocity error [mm/frame] of the standard and the stylized set.
const TWIST2: [(&str, [f64; 3]); 2] = [("standard", [28.6, 152.9, 4.30]), ("stylized", [32.9, 241.6, 5.91])];

/// The tracker's figures for each set in an engine; every clip must be completed.
fn twist2(data: &Path, engine: &str) -> Vec<(String, [f64; 3])> {
    let (policy, motions) = (data.join("peers/twist2/twist2_1017_20k.onnx"), data.join("motions/paid"));
    let (policy, motions) = (policy.to_string_lossy(), motions.to_string_lossy());
    let args = ["eval", "tracking", "--policy", &policy, "--motions", &motions, "--engine", engine];
    let args = [&args[..], &["--starts", "0", "--no-limits", "--json"]].concat();
    let report = json(&succeeds(&paid(data, &args)));
    let sets = report["sets"].as_array().expect("sets").iter();
    sets.map(|set| {
        assert_eq!(set["exact_completed"]["count"], set["exact_completed"]["trials"], "{set}");
        let error = |key: &str| set["exact"]["errors"][key].as_f64().expect("a number");
        let figures = ["mpjpe_mm", "g_mpjpe_mm", "velocity_error_mm"].map(error);
        (set["set"].as_str().expect("a name").to_owned(), figures)
    })
    .collect()
}

#[test]
fn the_twist2_tracker_scores_as_it_was_measured_elsewhere() {
    let test = "the_twist2_tracker_scores_as_it_was_measured_elsewhere";
    let Some(data) = shared(test) else { return };
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let found = twist2(&data, "mujoco");
    for (set, expected) in TWIST2 {
        let (_, figures) = found.iter().find(|(name, _)| name == set).expect("the set");
        for (figure, expected) in figures.iter().zip(expected) {
            // A tenth is the aim; arithmetic on another machine moves a figure by a few hundredths.
            assert!((figure / expected - 1.0).abs() < 0.15, "{set}: {figures:?}");
        }
    }
}

#[test]
fn the_twist2_tracker_runs_in_the_built_in_engine_with_its_own_gains() {
    let Some(data) = shared("the_twist2_tracker_runs_in_the_built_in_engine_with_its_own_gains") else {
        return;
    };
    for (set, [mpjpe, ..]) in twist2(&data, "builtin") {
        assert!((15.0..45.0).contains(&mpjpe), "{set}: {mpjpe}");
    }
}
