//! The committed policies still score in MuJoCo: 63 fixed shots with balls at rest, and 63 with rolling balls.
//!
//! The bounds lie some four standard deviations below what the policies' pages say. A policy plays with the knowledge that it was
//! trained with.

use std::path::Path;

use crate::common::{paid, succeeds};
use paid_mujoco::Library;
use serde_json::Value;

/// Goals of 63 shots: balls at rest, rolling balls.
fn goals(policy: &str, motions: Option<&Path>) -> [u64; 2] {
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies").join(policy);
    let policy = policy.to_string_lossy();
    let mut args = vec!["eval", "shooting", "--policy", &*policy, "--engine", "mujoco", "--ball", "both"];
    args.extend(["--effective", "--trials", "1", "--seed", "1", "--json"]);
    let motions = motions.map(Path::to_string_lossy);
    if let Some(motions) = &motions {
        args.extend(["--motions", &**motions]);
    }
    let text = succeeds(&paid(Path::new("."), &args));
    let mut goals = text.lines().map(|line| {
        let report: Value = serde_json::from_str(line).expect("JSON");
        assert_eq!(report["total"]["success"]["trials"], 63);
        report["total"]["success"]["count"].as_u64().expect("a number")
    });
    [goals.next().expect("balls at rest"), goals.next().expect("rolling balls")]
}

// Slow: plays 126 shots in MuJoCo, because its page promises those scores.
#[test]
fn the_demo_scores_in_mujoco() {
    let Some(_) = paid_testing::mujoco("the_demo_scores_in_mujoco", Library::get()) else { return };
    let [at_rest, rolling] = goals("demo/policy.onnx", None);
    assert!(at_rest >= 59, "{at_rest} goals of 63; 99.7% of 630 are on the policy's page");
    assert!(rolling >= 48, "{rolling} goals of 63; 92.4% of 630 are on the policy's page");
}

// Slow: plays 126 shots in MuJoCo, because its page promises those scores.
#[test]
fn paid13_scores_in_mujoco_by_its_own_eyes() {
    let test = "paid13_scores_in_mujoco_by_its_own_eyes";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let Some(motions) = paid_testing::shared_data(test, "data/motions/paid") else { return };
    let [at_rest, rolling] = goals("paid13/policy.onnx", Some(&motions));
    assert!(at_rest >= 57, "{at_rest} goals of 63; 98.6% of 630 are on the policy's page");
    assert!(rolling >= 48, "{rolling} goals of 63; 91.3% of 630 are on the policy's page");
}
