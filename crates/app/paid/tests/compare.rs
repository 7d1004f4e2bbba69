//! `paid compare` from end to end with a tiny budget.

use std::fs;
use std::path::Path;

use crate::common::{paid, refuses, succeeds};
use paid_mujoco::Library;

/// Three methods on the built-in kicks, 64 environments, two iterations each.
const PLAN: &str = r#"
    title = "a small comparison"
    samples = 3072
    sets = ["run.envs=64", "run.shards=4", "learn.ppo.minibatches=2", "learn.precision=\"f32\""]

    [judge]
    trials = 1
    grid_step_m = 2.0
    limit_s = 0.2
    likeness_trials = 1
    clip_trials = 1

    [[entry]]
    name = "Without clips"
    paper = "Pure RL"
    stages = [{ preset = "pure_rl" }]

    [[entry]]
    name = "AMP"
    paper = "AMP"
    stages = [{ preset = "amp" }]

    [[entry]]
    name = "Two stages"
    stages = [{ preset = "stage1" }, { preset = "stage2" }]
"#;

// Slow: trains three methods and scores each in MuJoCo, because the table needs them all.
#[test]
fn methods_are_trained_and_judged_once_and_stand_beside_the_papers() {
    let test = "methods_are_trained_and_judged_once_and_stand_beside_the_papers";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    fs::write(folder.path().join("plan.toml"), PLAN).expect("writes");
    let line = ["compare", "plan.toml", "--out", "out", "--threads", "1"];
    let output = paid(folder.path(), &line);
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    for progress in
        ["1 of 3: Without clips, seed 1, pure_rl: 50% of 2 iterations", ", stage2: 100% of 1 iterations"]
    {
        assert!(said.contains(progress), "{progress}: {said}");
    }
    let table = succeeds(&output);
    for word in
        ["a small comparison", "Without clips", "AMP", "Two stages", "truth", "33.0%", "46.8%", "the clips"]
    {
        assert!(table.contains(word), "{word}: {table}");
    }
    assert_eq!(fs::read_to_string(folder.path().join("out/comparison.txt")).expect("a table"), table);
    assert!(
        table.contains("near each clip's own ball") && table.matches("Two stages").count() > 5,
        "{table}"
    );
    let page = fs::read_to_string(folder.path().join("out/report.html")).expect("a page");
    assert!(page.contains("a small comparison") && page.contains("Two stages, seed 1"), "{page}");
    let one = |path: &str| fs::read_to_string(folder.path().join(path)).expect(path);
    assert_eq!(one("out/two-stages/seed-1/stage2/metrics.jsonl").lines().count(), 1);
    assert_eq!(one("out/amp/seed-1/amp/metrics.jsonl").lines().count(), 2);

    // Scores that are there are taken as they are, and nothing is trained again.
    let file = folder.path().join("out/amp/seed-1/scores.json");
    let before = fs::read_to_string(&file).expect("scores");
    let mut scores: serde_json::Value = serde_json::from_str(&before).expect("JSON");
    assert_eq!(scores["samples"], serde_json::json!([3072]));
    scores["judgments"][0]["fixed"]["accuracy"] = serde_json::json!(0.125);
    fs::write(&file, scores.to_string()).expect("writes");
    // Its checkpoints are not needed either.
    for entry in fs::read_dir(folder.path().join("out/amp/seed-1/amp")).expect("a run").flatten() {
        if entry.path().extension().is_some_and(|extension| extension == "safetensors" || extension == "onnx")
        {
            fs::remove_file(entry.path()).expect("removes");
        }
    }
    let output = paid(folder.path(), &[&line[..], &["--json", "--quiet"]].concat());
    let json = succeeds(&output);
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
    let report: serde_json::Value = serde_json::from_str(json.trim()).expect("JSON");
    assert_eq!(report["rows"][1]["scores"]["judgments"][0]["fixed"]["accuracy"], 0.125);
    assert_eq!(one("out/amp/seed-1/amp/metrics.jsonl").lines().count(), 2);

    // Another number of samples would make a hybrid of what is there.
    for (samples, iterations) in [("6144", 4), ("1536", 1)] {
        let other = PLAN.replace("samples = 3072", &format!("samples = {samples}"));
        fs::write(folder.path().join("plan.toml"), other).expect("writes");
        let error = refuses(&paid(folder.path(), &line));
        let expected = format!("expected run.iterations = {iterations}, as in this plan, found 2");
        assert!(error.contains(&expected) && error.contains("without-clips"), "{error}");
    }
}

/// The first stage was trained elsewhere; of it came what the book says.
// Slow: trains and scores a method, then twice from a carried stage, because it may have been killed there.
#[test]
fn a_finished_stage_is_carried_and_only_what_is_asked_for_is_trained() {
    let test = "a_finished_stage_is_carried_and_only_what_is_asked_for_is_trained";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path();
    let plan = PLAN.replace("likeness_trials = 1", "").replace("clip_trials = 1", "");
    fs::write(path.join("plan.toml"), plan).expect("writes");
    let line = |out: &'static str, only: &'static str| {
        ["compare", "plan.toml", "--threads", "1", "--out", out, "--only", only]
    };
    let error = refuses(&paid(path, &line("there", "Two stage")));
    let names = "('Without clips', 'AMP', 'Two stages'), found 'Two stage'";
    assert!(error.contains("--only: expected an entry of the plan") && error.contains(names), "{error}");

    let table = succeeds(&paid(path, &line("there", "Two stages")));
    assert!(table.contains("Two stages") && !table.contains("AMP"), "{table}");
    assert!(!path.join("there/amp").exists(), "nothing else is trained");

    let [from, to] = ["there", "here"].map(|out| path.join(out).join("two-stages/seed-1/stage1"));
    fs::create_dir_all(&to).expect("made");
    let copy = |name: &str| fs::copy(from.join(name), to.join(name)).expect("copied");
    copy("metrics.jsonl");
    copy("policy.onnx");
    let error = refuses(&paid(path, &line("here", "Two stages")));
    assert!(error.contains("preset.toml: expected the preset of the run"), "{error}");
    copy("preset.toml");
    // The next stage continues with the critic, which the policy file does not hold.
    let error = refuses(&paid(path, &line("here", "Two stages")));
    assert!(error.contains("stage1/policy.onnx: a policy file holds no critic"), "{error}");
    let runs = fs::read_dir(&from).expect("a run").flatten().map(|entry| entry.file_name());
    let models: Vec<_> = runs.filter(|name| name.to_string_lossy().starts_with("model_")).collect();
    for name in &models {
        copy(&name.to_string_lossy());
    }
    let output = paid(path, &line("here", "Two stages"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    succeeds(&output);
    assert!(said.contains("stage2: 100%") && !said.contains("stage1: "), "{said}");
    for name in
        models.iter().filter_map(|name| name.to_str()).chain(["policy.onnx", "metrics.jsonl", "preset.toml"])
    {
        let [before, after] = [&from, &to].map(|run| fs::read(run.join(name)).expect("a file"));
        assert!(before == after, "{name}: the carried stage is left as it is");
    }

    // Killed before its first checkpoint, the second stage starts from scratch.
    let entry = path.join("here/two-stages/seed-1");
    fs::remove_file(entry.join("scores.json")).expect("removed");
    for file in fs::read_dir(entry.join("stage2")).expect("a run").flatten() {
        if file.path().extension().is_some_and(|extension| extension == "safetensors" || extension == "onnx")
        {
            fs::remove_file(file.path()).expect("removed");
        }
    }
    let output = paid(path, &line("here", "Two stages"));
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    succeeds(&output);
    assert!(said.contains("stage2: 100%"), "{said}");

    fs::write(entry.join("origin.txt"), "other clips").expect("writes");
    let error = refuses(&paid(path, &line("here", "Two stages")));
    assert!(
        error.contains("origin.txt: expected runs of the origin 'the built-in kicks', found 'other clips"),
        "{error}"
    );
}

#[test]
fn a_plan_that_does_not_fit_is_refused_before_anything_is_trained() {
    let folder = tempfile::tempdir().expect("folder");
    let refused = |plan: &str, also: &[&str]| {
        fs::write(folder.path().join("plan.toml"), plan).expect("writes");
        let line = [&["compare", "plan.toml", "--out", "out"], also].concat();
        let error = refuses(&paid(folder.path(), &line));
        assert!(!Path::new(&folder.path().join("out")).exists(), "nothing is written");
        error
    };
    let error = refused(&PLAN.replace("[judge]", "[judgement]"), &[]);
    assert!(error.contains("plan.toml") && error.contains("judgement"), "{error}");
    let error = refused(&PLAN.replace("samples = 3072", "samples = 0"), &[]);
    assert!(error.contains("samples: expected at least 1, found 0"), "{error}");
    let error = refused(&PLAN.replace(r#""run.shards=4""#, r#""run.shardz=4""#), &[]);
    assert!(error.contains("run.shardz"), "{error}");
    let error = refused(PLAN, &["--motions", "absent"]);
    assert!(error.contains("absent"), "{error}");
}

/// One policy for all clips, and a policy for each of two.
const TRACKERS: &str = r#"
    title = "followers"
    samples = 3072
    sets = ["run.envs=64", "run.shards=4", "learn.ppo.minibatches=2", "learn.precision=\"f32\""]

    [judge]
    tracking_starts = 1

    [[entry]]
    name = "One for all"
    stages = [{ preset = "stage1" }]

    [[entry]]
    name = "One each"
    stages = [{ preset = "stage1" }]
    specialists = true
    clips = ["kick-a", "kick-b"]
"#;

#[test]
fn specialists_are_trained_and_judged_on_their_own_clips() {
    let test = "specialists_are_trained_and_judged_on_their_own_clips";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path();
    for (ball, name) in [("0.9,-0.2", "kick-a"), ("0.9,0.2", "kick-b"), ("1.4,0.0", "kick-c")] {
        succeeds(&paid(path, &["motion", "generate", "--out", "made", "--ball", ball]));
        let file = fs::read_dir(path.join("made")).expect("made").flatten().next().expect("a motion").path();
        fs::create_dir_all(path.join("clips/standard")).expect("made");
        fs::rename(file, path.join(format!("clips/standard/{name}.npz"))).expect("moved");
    }
    fs::write(path.join("plan.toml"), TRACKERS).expect("writes");
    let line = ["compare", "plan.toml", "--motions", "clips", "--out", "out", "--threads", "1", "--json"];
    let report: serde_json::Value =
        serde_json::from_str(succeeds(&paid(path, &line)).trim()).expect("a report");
    let clips: Vec<Vec<&str>> = report["rows"]
        .as_array()
        .expect("rows")
        .iter()
        .map(|row| row["scores"]["tracks"].as_array().expect("tracks"))
        .map(|tracks| tracks.iter().map(|track| track["clip"].as_str().expect("a name")).collect())
        .collect();
    assert_eq!(clips, [vec!["kick-a", "kick-b", "kick-c"], vec!["kick-a"], vec!["kick-b"]]);
    let table = fs::read_to_string(path.join("out/comparison.txt")).expect("a table");
    assert!(table.contains("BeyondMimic, the paper's figures"), "{table}");
    let preset =
        fs::read_to_string(path.join("out/one-each/seed-1/kick-b/stage1/preset.toml")).expect("a run");
    assert!(preset.contains("motions = \"clips/standard/kick-b.npz\""), "{preset}");

    fs::write(path.join("plan.toml"), TRACKERS.replace("\"kick-b\"", "\"kick-z\"")).expect("writes");
    let error = refuses(&paid(path, &line));
    assert!(error.contains("expected clips of clips: kick-a, kick-b, kick-c, found kick-z"), "{error}");
}

/// Killed while it trains its second policy, which has a checkpoint, and called again.
// Slow: trains and scores two methods, the second for 20 iterations, because there must be time to kill it.
#[test]
fn a_killed_comparison_goes_on_and_repeats_no_finished_part() {
    let test = "a_killed_comparison_goes_on_and_repeats_no_finished_part";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path();
    // Eight iterations and twenty: there is time to kill it between the first checkpoint and the end.
    let plan = PLAN.replace("samples = 3072", "samples = 12288").replace("likeness_trials = 1", "");
    let plan =
        plan.replace("clip_trials = 1", "").replace("name = \"AMP\"", "name = \"AMP\"\n    samples = 30720");
    let (plan, _) = plan.split_once("[[entry]]\n    name = \"Two stages\"").expect("three entries");
    fs::write(
        path.join("plan.toml"),
        plan.replace("run.shards=4\"", "run.shards=4\", \"run.checkpoint_interval=1\""),
    )
    .expect("writes");
    let line = ["compare", "plan.toml", "--out", "out", "--threads", "1"];
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_paid"))
        .current_dir(path)
        .args(line)
        .stdout(std::process::Stdio::null())
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("starts");
    let log = path.join("out/amp/seed-1/amp/metrics.jsonl");
    let iterations = || fs::read_to_string(&log).map_or(0, |text| text.lines().count());
    while iterations() < 3 {
        assert!(child.try_wait().expect("a child").is_none(), "it ended before its third iteration");
        std::thread::sleep(std::time::Duration::from_millis(20));
    }
    child.kill().expect("killed");
    child.wait().expect("ended");
    let before = iterations();
    assert!(before < 20 && !path.join("out/amp/seed-1/scores.json").exists(), "killed on its way: {before}");
    let finished = ["out/without-clips/seed-1/scores.json", "out/without-clips/seed-1/pure_rl/metrics.jsonl"];
    let changed =
        || finished.map(|file| fs::metadata(path.join(file)).and_then(|m| m.modified()).expect(file));
    let then = changed();

    let table = succeeds(&paid(path, &line));
    assert!(table.contains("Without clips") && table.contains("AMP"), "{table}");
    assert_eq!(changed(), then, "what was finished is left alone");
    assert_eq!(iterations(), 20, "the second policy continues: each iteration is logged once");
}
