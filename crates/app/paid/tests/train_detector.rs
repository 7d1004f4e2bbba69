//! `paid perceive train`: two steps, and the file is a detector. The committed network's detection rate is tested elsewhere.

use crate::common::{paid, refuses, succeeds};
use serde_json::Value;

#[test]
fn a_short_training_writes_a_file_that_the_detector_reads() {
    let folder = tempfile::tempdir().expect("a folder");
    let train = ["perceive", "train", "--steps", "2", "--batch", "1", "--out", "ball.onnx", "--json"];
    let text = succeeds(&paid(folder.path(), &train));
    let last: Value = serde_json::from_str(text.lines().last().expect("a line")).expect("JSON");
    assert_eq!(last["step"], 2);
    assert!(last["heat"].as_f64().is_some_and(|loss| loss > 0.0), "{last}");
    let size = std::fs::metadata(folder.path().join("ball.onnx")).expect("the network").len();
    assert!((1_000_000..2_000_000).contains(&size), "{size} bytes");
    let judge = ["perceive", "detect", "--detector", "ball.onnx", "--held-out", "1", "--json"];
    let report: Value = serde_json::from_str(&succeeds(&paid(folder.path(), &judge))).expect("JSON");
    assert_eq!(report["pictures"], 2);
    let error = refuses(&paid(folder.path(), &["perceive", "train", "--batch", "0"]));
    assert!(error.contains("batch"), "{error}");
}
