//! `paid ablate` from end to end with a tiny budget.

mod common;

use std::fs;

use common::{paid, refuses, small, succeeds, write_motions};
use paid_mujoco::Library;

#[test]
fn three_variants_are_trained_judged_and_not_done_twice() {
    let test = "three_variants_are_trained_judged_and_not_done_twice";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let stage1 =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "one", "--quiet"]);
    succeeds(&paid(folder.path(), &stage1));
    let line = [
        "ablate",
        "--from",
        "one",
        "--motions",
        "motions",
        "--out",
        "out",
        "--iterations",
        "1",
        "--trials",
        "2",
        "--workspace-trials",
        "1",
        "--limit",
        "0.1",
        "--threads",
        "1",
    ];
    let table = succeeds(&paid(folder.path(), &small(&line)));
    for word in ["full", "w/o identification", "w/o observation noise", "hard", "grass", "/2"] {
        assert!(table.contains(word), "{word}: {table}");
    }
    let file = folder.path().join("out/stage3/hard.json");
    let before = fs::read_to_string(&file).expect("a score");
    // A score that is there is taken as it is.
    let changed = before.replace("\"surface\": \"hard\"", "\"surface\": \"known\"");
    assert_ne!(changed, before);
    fs::write(&file, &changed).expect("writes");
    let output = paid(folder.path(), &small(&[&line[..], &["--json", "--quiet"]].concat()));
    let json = succeeds(&output);
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    let report: serde_json::Value = serde_json::from_str(json.trim()).expect("JSON");
    let scores = report["scores"].as_array().expect("scores");
    assert_eq!(scores.len(), 6);
    assert_eq!(scores[0]["surface"], "known");
    assert_eq!(scores[5]["workspace"]["trials"], 63);
    let other = small(&[&line[..], &["--set", "run.seed=9"]].concat());
    assert!(refuses(&paid(folder.path(), &other)).contains("preset.toml"));
    let error = refuses(&paid(folder.path(), &["ablate", "--from", "absent"]));
    assert!(error.contains("absent"), "{error}");
}
