//! `paid eval` from end to end, on an untrained policy and motions of our own.

use std::fs;
use std::path::Path;

use crate::common::{folder, paid, refuses, succeeds};
use paid_mujoco::Library;
use serde_json::Value;

fn json(text: &str) -> Value {
    serde_json::from_str(text.trim()).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// True if MuJoCo is here; without it the test, or its part, is skipped.
fn mujoco(test: &str) -> bool {
    paid_testing::mujoco(test, Library::get()).is_some()
}

#[test]
fn tracking_prints_one_line_of_json_and_writes_the_same() {
    let folder = folder();
    let args = ["eval", "tracking", "--policy", "run", "--starts", "2", "--out", "scores", "--json"];
    let text = succeeds(&paid(folder.path(), &args));
    assert_eq!(text.trim().lines().count(), 1);
    let report = json(&text);
    assert_eq!(report["kind"], "tracking");
    assert_eq!(
        report["runs"].as_array().map(Vec::len),
        Some(6),
        "two motions, one exact and two other starts"
    );
    assert_eq!(report["timing"]["trials"], 6);
    let file = fs::read_to_string(folder.path().join("scores/builtin_tracking.json")).expect("the file");
    assert_eq!(json(&file), report);
    for name in ["errors.png", "errors.svg"] {
        let path = folder.path().join(format!("scores/builtin_tracking_{name}"));
        assert!(fs::metadata(path).is_ok_and(|m| m.len() > 100), "{name}");
    }
    let table = succeeds(&paid(folder.path(), &["eval", "tracking", "--policy", "run", "--starts", "0"]));
    assert!(table.contains("swing_left") && table.contains("this policy, exact"), "{table}");
    assert!(
        !table.contains("this policy, perturbed"),
        "nothing is said about starts that were not run: {table}"
    );
}

#[test]
fn shooting_writes_every_trial_and_every_figure() {
    let folder = folder();
    let args =
        ["eval", "shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "1", "--limit", "1"];
    let args = [&args[..], &["--effective", "--ball", "both", "--out", "scores", "--json"]].concat();
    let text = succeeds(&paid(folder.path(), &args));
    let lines: Vec<&str> = text.trim().lines().collect();
    assert_eq!(lines.len(), 2, "a line a kind of ball");
    let written = |name: &str| folder.path().join("scores").join(name);
    for (line, ball) in lines.iter().zip(["static", "rolling"]) {
        let report = json(line);
        assert_eq!(report["trials"].as_array().map(Vec::len), Some(63));
        assert_eq!(report["options"]["rolling"].is_null(), ball == "static");
        let file = |name: &str| written(&format!("builtin_{ball}_{name}"));
        let csv = fs::read_to_string(file("trials.csv")).expect("the trials");
        assert_eq!(csv.lines().count(), 64);
        for name in ["success", "accuracy", "paths"] {
            let png = fs::read(file(&format!("{name}.png"))).expect("an image");
            let svg = fs::read_to_string(file(&format!("{name}.svg"))).expect("a vector image");
            assert!(
                png.starts_with(b"\x89PNG") && svg.starts_with("<svg") && svg.ends_with("</svg>\n"),
                "{name}"
            );
        }
        assert!(file("shooting.json").is_file());
    }
    // The paper's four panels are one image: two maps of 63 cells per ball.
    let panels = fs::read_to_string(written("builtin_summary_panels.svg")).expect("the panels");
    for title in
        ["success [%], static", "success [%], rolling", "accuracy x 100, static", "accuracy x 100, rolling"]
    {
        assert!(panels.contains(title), "{title}");
    }
    assert_eq!(panels.matches("<rect").count(), 1 + 4 * 63);
    assert!(written("builtin_summary_panels.png").is_file());
    let page = fs::read_to_string(written("report.html")).expect("the report");
    for section in ["builtin_static", "builtin_rolling", "builtin_summary"] {
        assert!(page.contains(&format!(">{section}<")), "{section}");
    }
    assert_eq!(page.matches("<svg").count(), 11, "three images and two charts per ball, and the panels");
    assert_eq!(page.matches("<tr class=").count(), 2 * 63, "a row a shot");
    assert!(page.contains("Command:</p><pre>paid eval shooting"), "the command");
    assert!(!page.contains("src=\"http") && !page.contains("http-equiv"), "the report needs no network");
}

#[test]
fn a_score_of_what_the_robot_sees_says_so() {
    let folder = folder();
    let args =
        ["eval", "shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "1", "--limit", "0.1"];
    let asked = ["--effective", "--knowledge", "perceived", "--eyes-noise", "2", "--eyes-latency-ms", "100"];
    let text = succeeds(&paid(folder.path(), &[&args[..], &asked, &["--out", "scores"]].concat()));
    assert!(text.contains("knowledge: perceived (the tracker's ball position"), "{text}");
    assert!(text.contains("0.1 s old") && text.contains("scaled by 2 unknown to the tracker"), "{text}");
    let csv = fs::read_to_string(folder.path().join("scores/builtin_static_trials.csv")).expect("the trials");
    assert!(csv.lines().skip(1).all(|line| line.ends_with(",perceived")), "{csv}");
}

#[test]
fn an_onnx_file_scores_as_its_checkpoint_does() {
    let folder = folder();
    let score = |policy: &str| {
        let args =
            ["eval", "tracking", "--policy", policy, "--motions", "motions", "--starts", "0", "--json"];
        json(&succeeds(&paid(folder.path(), &args)))
    };
    let (checkpoint, onnx) = (score("run"), score("run/policy.onnx"));
    for (a, b) in
        checkpoint["runs"].as_array().expect("runs").iter().zip(onnx["runs"].as_array().expect("runs"))
    {
        let error = |run: &Value| run["errors"]["mpjpe_mm"].as_f64().expect("a number");
        assert_eq!(a["frames"], b["frames"]);
        assert!((error(a) - error(b)).abs() < 0.05 * error(a), "{} and {}", error(a), error(b));
    }
}

#[test]
fn both_engines_run_the_same_trials() {
    if !mujoco("both_engines_run_the_same_trials") {
        return;
    }
    let folder = folder();
    let args =
        ["eval", "shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "1", "--limit", "0.5"];
    let args = [&args[..], &["--engine", "both", "--effective", "--out", "scores", "--json"]].concat();
    let report = json(&succeeds(&paid(folder.path(), &args)));
    assert_eq!(report["pairs"].as_array().map(Vec::len), Some(63));
    let csv = fs::read_to_string(folder.path().join("scores/both_static_trials.csv")).expect("the pairs");
    assert_eq!(csv.lines().count(), 64);

    // Where a rolling ball will be depends on the engine's ball; which motion meets it must not.
    let args =
        ["eval", "shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "2", "--limit", "0.1"];
    // Thirteen kicks, so that there is a choice.
    succeeds(&paid(folder.path(), &["motion", "generate", "--out", "kicks"]));
    let terms = r#"observations.policy=["reference_joint_pos", "reference_joint_vel", "projected_gravity", "reference_anchor_ang_vel", "base_ang_vel", "joint_pos_rel", "joint_vel", "last_action", "ball_at_strike", "goal_pos"]"#;
    let rolling = ["--motions", "kicks", "--ball", "rolling", "--set", terms];
    let args = [&args[..], &rolling, &["--engine", "both", "--effective", "--json"]].concat();
    let report = json(&succeeds(&paid(folder.path(), &args)));
    let trials = |engine: &str| -> Vec<Value> {
        let all = report[engine]["trials"].as_array().expect("trials");
        let planned =
            |t: &Value| serde_json::json!([t["motion"], t["ball"], t["ball_velocity"], t["goal_xy"]]);
        all.iter().inspect(|t| assert!(t["motion"].is_u64(), "{t}")).map(planned).collect()
    };
    assert_eq!(trials("builtin").len(), 126);
    assert_eq!(trials("builtin"), trials("mujoco"));

    let args =
        ["eval", "tracking", "--policy", "run", "--engine", "both", "--starts", "1", "--out", "scores"];
    let table = succeeds(&paid(folder.path(), &args));
    assert!(table.contains("MuJoCo 3.") && table.contains("built-in"), "{table}");
    assert!(table.contains("what diverged first") && table.contains("of 4 runs"), "{table}");
    let csv = fs::read_to_string(folder.path().join("scores/both_tracking_runs.csv")).expect("the pairs");
    assert_eq!(csv.lines().count(), 5);
}

#[test]
fn a_panel_has_a_row_a_ball_and_kind() {
    if !mujoco("a_panel_has_a_row_a_ball_and_kind") {
        return;
    }
    let folder = folder();
    let args = ["eval", "panel", "--policy", "run", "--task", "paper_stage2", "--limit", "0.04", "--json"];
    let report =
        json(&succeeds(&paid(folder.path(), &[&args[..], &["--out", "scores", "--held-out"]].concat())));
    assert_eq!(report["parts"].as_array().map(Vec::len), Some(2));
    assert_eq!(report["parts"][1]["rows"].as_array().map(Vec::len), Some(11));
    assert_eq!(report["parts"][0]["rows"][4]["ball"]["name"], "dead");
    assert!(report["title"].as_str().is_some_and(|t| t.contains("HELD OUT")), "{report}");
    let csv = fs::read_to_string(folder.path().join("scores/panel_held_out.csv")).expect("the table");
    assert_eq!(csv.lines().count(), 23);
}

#[test]
fn robustness_has_a_row_for_each_thing_that_goes_wrong() {
    if !mujoco("robustness_has_a_row_for_each_thing_that_goes_wrong") {
        return;
    }
    let folder = folder();
    let args =
        ["eval", "robustness", "--policy", "run", "--task", "paper_stage2", "--limit", "0.04", "--json"];
    let report = json(&succeeds(&paid(folder.path(), &[&args[..], &["--out", "scores"]].concat())));
    assert_eq!(report["rows"].as_array().map(Vec::len), Some(11));
    assert_eq!(report["rows"][2]["trouble"]["push"]["before_strike"], false);
    let csv = fs::read_to_string(folder.path().join("scores/robustness.csv")).expect("the table");
    assert!(csv.lines().count() == 12 && csv.contains("\nfloor friction 0.4,63,"), "{csv}");
}

#[test]
fn terrain_has_a_row_for_each_ground() {
    if !mujoco("terrain_has_a_row_for_each_ground") {
        return;
    }
    let folder = folder();
    let args = ["eval", "terrain", "--policy", "run", "--task", "paper_stage2", "--limit", "0.04", "--json"];
    let report = json(&succeeds(&paid(folder.path(), &[&args[..], &["--out", "scores"]].concat())));
    assert_eq!(report["rows"].as_array().map(Vec::len), Some(8));
    assert_eq!(report["rows"][2]["trouble"]["ground"], "rough-2cm");
    let csv = fs::read_to_string(folder.path().join("scores/terrain.csv")).expect("the table");
    assert!(csv.starts_with("ground,trials,success,95% interval,"), "{csv}");
    assert!(csv.lines().count() == 9 && csv.contains("\nslope-4deg,63,"), "{csv}");
}

#[test]
fn every_protocol_is_played_on_the_ground_that_is_named() {
    if !mujoco("every_protocol_is_played_on_the_ground_that_is_named") {
        return;
    }
    let folder = folder();
    let on_ground = ["--policy", "run", "--engine", "mujoco", "--ground", "rough-1cm"];
    for (kind, more) in [
        ("tracking", &["--starts", "0"][..]),
        ("shooting", &["--task", "paper_stage2", "--effective", "--trials", "1", "--limit", "0.04"]),
        ("match", &["--task", "paper_stage2", "--kicks", "1", "--matches", "1"]),
    ] {
        let table = succeeds(&paid(folder.path(), &[&["eval", kind], &on_ground[..], more].concat()));
        assert!(table.contains("rough by 0.01 m"), "{kind}: {table}");
    }
    succeeds(&paid(folder.path(), &["eval", "scene", "--ground", "rough-1cm"]));
    let scene = fs::read_to_string(folder.path().join("scene.xml")).expect("the scene");
    assert!(scene.contains(r#"type="hfield" hfield="ground""#));
}

#[test]
fn a_match_ends_with_the_first_fall_and_is_filmed() {
    let folder = folder();
    let args =
        ["eval", "match", "--policy", "run", "--task", "paper_stage2", "--kicks", "2", "--matches", "2"];
    let args = [&args[..], &["--out", "scores", "--film", "match.gif", "--film-kicks", "1"]].concat();
    let table = succeeds(&paid(folder.path(), &args));
    assert!(table.contains("2 matches of 2 kicks, robot never reset"), "{table}");
    for name in ["scores/builtin_match_static.csv", "scores/builtin_match_static.json", "match.gif"] {
        assert!(folder.path().join(name).is_file(), "{name}");
    }
    let both = [&args[..], &["--engine", "both"]].concat();
    assert!(refuses(&paid(folder.path(), &both)).contains("expected builtin or mujoco"));
}

#[test]
fn a_robot_is_watched_after_its_kick_as_long_as_asked() {
    let folder = folder();
    let args =
        ["eval", "shooting", "--policy", "run", "--task", "paper_stage2", "--trials", "1", "--limit", "0.1"];
    let args = [&args[..], &["--effective", "--after-s", "0.2", "--json"]].concat();
    let report = json(&succeeds(&paid(folder.path(), &args)));
    assert_eq!(report["options"]["after_s"], 0.2);
    assert_eq!(report["total"]["falls_within"]["trials"], 63);
    assert!(report["total"]["falls_in_clip"]["share"].is_number());
}

#[test]
fn a_film_has_a_strip_and_frames() {
    let folder = folder();
    let args =
        ["eval", "film", "--policy", "run", "--task", "paper_stage2", "--frames", "film", "--limit", "0.5"];
    succeeds(&paid(folder.path(), &[&args[..], &["--rate", "5", "--ball", "0.8,-0.1"]].concat()));
    for name in ["strip.png", "paths.png", "paths.svg", "frame_0000.png"] {
        assert!(folder.path().join("film").join(name).is_file(), "{name}");
    }
}

// Slow: plays 63 shots and films two of them, because the command does all of it.
#[test]
fn a_demo_scores_draws_and_records() {
    let folder = folder();
    let error = refuses(&paid(folder.path(), &["demo", "--policy", "run", "--motions", "motions"]));
    assert!(error.contains("task 'stage1': expected one with a physical ball"), "{error}");
    let policy = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    fs::copy(policy, folder.path().join("policy.onnx")).expect("copies");
    let args = ["demo", "--policy", "policy.onnx", "--motions", "motions", "--trials", "1", "--record", "2"];
    let report = json(&succeeds(&paid(folder.path(), &[&args[..], &["--json"]].concat())));
    assert_eq!((&report["kind"], report["trials"].as_array().map(Vec::len)), (&"demo".into(), Some(63)));
    let balls: std::collections::BTreeSet<String> = report["trials"]
        .as_array()
        .expect("trials")
        .iter()
        .map(|trial| trial["ball"][0].to_string())
        .collect();
    assert_eq!(balls.len(), 63, "every ball lies somewhere else");
    let demo = folder.path().join("demo");
    for name in ["shots.gif", "shot_1.png", "shot_2.png", "report.html", "builtin_static_success.png"] {
        assert!(fs::metadata(demo.join(name)).is_ok_and(|m| m.len() > 100), "{name}");
    }
    assert!(!demo.join("shot_3.png").exists());
}

#[test]
fn the_programs_own_policy_still_scores_with_the_built_in_kicks() {
    let folder = tempfile::tempdir().expect("folder");
    let args = ["demo", "--trials", "1", "--record", "0", "--json"];
    let report = json(&succeeds(&paid(folder.path(), &args)));
    // Measured: 97% (252 trials). If a change of engine, task or generator breaks this, the policy must be trained again.
    let success = report["total"]["success"]["share"].as_f64().expect("a share");
    assert!(success > 0.9, "{success}");
    assert!(folder.path().join("demo/policy.onnx").is_file());
    let text = succeeds(&paid(folder.path(), &args[..5]));
    let lines: Vec<&str> = text.lines().collect();
    assert_eq!(lines.len(), 3, "{text}");
    assert!(
        lines[0].contains("% of 63 shots scored") && lines[1].contains("simulated sensor errors"),
        "{text}"
    );
    assert!(lines[2].starts_with("See demo/report.html."), "{text}");
}

#[test]
fn the_scene_is_written_for_mujocos_viewer() {
    let folder = tempfile::tempdir().expect("folder");
    let printed = succeeds(&paid(folder.path(), &["eval", "scene", "--scene", "public", "--print"]));
    let edited = printed.replace("floor_friction = 0.8", "floor_friction = 0.55");
    let edited = edited.replace("no_friction_loss = false", "no_friction_loss = true");
    fs::write(folder.path().join("mine.toml"), edited).expect("writes");
    succeeds(&paid(folder.path(), &["eval", "scene", "--scene", "mine.toml", "--out", "scene.xml"]));
    let xml = fs::read_to_string(folder.path().join("scene.xml")).expect("the scene");
    assert!(xml.contains("friction=\"0.55 ") && xml.contains("mass=\"0.1\""), "{xml}");
    assert!(!xml.contains("frictionloss=\"0.1\""), "{xml}");
}

#[test]
fn a_policys_contacts_are_measured_and_kept_in_its_file() {
    let folder = tempfile::tempdir().expect("folder");
    let demo = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
    let file = folder.path().join("policy.onnx");
    fs::copy(&demo, &file).expect("copies");
    let measure = |also: &[&str]| {
        let args = ["eval", "contacts", "--policy", "policy.onnx", "--json"];
        json(&succeeds(&paid(folder.path(), &[&args[..], also].concat())))
    };
    // As if they had not been measured: the balls are at rest, so that makes no difference.
    let found = measure(&["--set", "ball.contact_s={}", "--keep"]);
    let rows = found["rows"].as_array().expect("rows");
    assert_eq!(rows.len(), 13);
    for row in rows {
        let [strike, contact] = ["strike_s", "contact_s"].map(|key| row[key].as_f64().expect("a time"));
        assert!((0.1..0.35).contains(&(strike - contact)), "{row}");
        assert!(row["spread_s"].as_f64().is_some_and(|spread| spread <= 0.02), "{row}");
    }
    let [shipped, kept] = [&demo, &file].map(|path| paid_train::TrainedPolicy::load(path).expect("reads"));
    let task = &kept.preset.task;
    let first = rows[0]["motion"].as_str().expect("a name");
    assert_eq!(Some(task.ball.contact_s[first]), rows[0]["contact_s"].as_f64());
    assert!(task.mirror_left_kicks, "as the demo is played");
    assert_eq!(kept.policy.params, shipped.policy.params);

    let args = ["export", "policy.onnx", "--out", "again.onnx", "--json"];
    let contract = &json(&succeeds(&paid(folder.path(), &args)))["contract"];
    assert_eq!(contract["play"]["mirror_left_kicks"], true, "{contract}");
    assert_eq!(contract["play"]["contact_s"][first], rows[0]["contact_s"], "{contract}");
    assert_eq!(
        contract["play"]["where_it_lay"]["from_s"], 0.3,
        "a ball that flies off makes it fall: {contract}"
    );

    let error = refuses(&paid(folder.path(), &["eval", "contacts", "--policy", ".", "--keep"]));
    assert!(error.contains("--keep: expected --policy to be a file"), "{error}");
}
