//! Commands from end to end, on a motion of our own.

use std::fs;

use crate::common::{SMALL, paid, refuses, small, succeeds, swing, write_motions};
use paid_motion::{KickLeg, write_npz};
use paid_onnx::OnnxPolicy;
use paid_policy::Checkpoint;
use paid_robot::{RobotModel, RobotSpec};
use serde_json::Value;

fn json(line: &str) -> Value {
    serde_json::from_str(line).unwrap_or_else(|error| panic!("{error}: {line}"))
}

#[test]
fn motion_info_prints_every_clip_as_text_and_json() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let text = succeeds(&paid(folder.path(), &["motion", "info", "motions"]));
    assert!(text.contains("swing_left") && text.contains("swing_right"), "{text}");
    let text = succeeds(&paid(folder.path(), &["motion", "info", "motions", "--json"]));
    assert!(text.contains("swing_left"), "{text}");
    json(&text);
}

#[cfg(unix)]
#[test]
fn a_reader_that_went_away_ends_the_program_in_silence() {
    use std::os::unix::process::ExitStatusExt;
    use std::process::Command;

    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    for args in [&["--help"][..], &["motion", "info", "motions"]] {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let mut command = Command::new(env!("CARGO_BIN_EXE_paid"));
        let output = command.args(args).current_dir(folder.path()).stdout(writer).output().expect("starts");
        let error = String::from_utf8_lossy(&output.stderr);
        assert!(error.is_empty(), "{args:?}: {error}");
        assert_eq!(output.status.signal(), Some(13), "{args:?}: SIGPIPE, as of any other program");
    }
}

/// Output on a disk that is full.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_behind_standard_output_is_one_error() {
    use std::process::Command;

    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    for args in [
        &["motion", "info", "motions"][..],
        &["task", "terms"],
        &["train", "stage1", "--explain"],
        &["train", "stage1", "--explain", "--json"],
    ] {
        let full = fs::OpenOptions::new().write(true).open("/dev/full").expect("Linux has it");
        let mut command = Command::new(env!("CARGO_BIN_EXE_paid"));
        let output = command.args(args).current_dir(folder.path()).stdout(full).output().expect("starts");
        let error = refuses(&output);
        assert!(error.starts_with("error: standard output: No space left on device"), "{args:?}: {error}");
    }
}

#[test]
fn a_preset_or_a_run_of_the_other_stage_is_refused_before_anything_is_trained() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let base = ["train", "--motions", "motions", "--iterations", "1", "--quiet"];
    let error = refuses(&paid(folder.path(), &small(&[&base[..], &["--stage1-preset", "stage2"]].concat())));
    assert!(error.contains("--stage1-preset stage2: Stage I follows motions without a ball"), "{error}");
    for preset in ["stage2", "amp", "pure_rl", "pure_rl_scattered", "single_stage"] {
        let error = refuses(&paid(folder.path(), &["train", "stage1", "--preset", preset, "--explain"]));
        assert!(error.contains(&format!("--preset {preset}: Stage I follows motions")), "{error}");
        succeeds(&paid(folder.path(), &["train", "stage2", "--preset", preset, "--explain"]));
    }
    assert!(!folder.path().join("runs").exists());

    let one =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "one", "--quiet"]);
    succeeds(&paid(folder.path(), &one));
    let resume = ["train", "stage2", "--resume", "--iterations", "2", "--out", "one"];
    let error = refuses(&paid(folder.path(), &resume));
    assert!(error.contains("--resume: the run in one: Stage II kicks a ball"), "{error}");
    assert!(!folder.path().join("one/model_2.safetensors").exists());
}

#[test]
fn numbers_that_no_machine_holds_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    for (args, expected) in [
        (
            &["train", "stage1", "--set", "run.envs=1000000000000"][..],
            "run.envs: expected at most 1000000, found 1000000000000",
        ),
        (
            &["train", "stage1", "--set", "run.shards=4611686018427387904"],
            "run.shards: expected at most 1000000, found 4611686018427387904",
        ),
        (&["train", "stage1", "--threads", "99999999"], "--threads: expected 1 to 1024, found 99999999"),
        (&["agent", "zero", "--envs", "10000000000"], "expected 1 to 1000000, found '10000000000'"),
        (&["bench", "train", "--seconds", "-1"], "--seconds: expected above 0, at most 3600, found -1"),
    ] {
        let error = refuses(&paid(folder.path(), args));
        assert!(error.contains(expected), "{args:?}: {error}");
    }
}

#[test]
fn a_file_of_motions_and_a_change_without_a_value_are_refused() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    for command in [&["train", "stage1"][..], &["agent", "zero"]] {
        let file = [command, &["--motions", "motions/swing_left.npz"]].concat();
        let error = refuses(&paid(folder.path(), &file));
        assert!(error.contains("--motions: expected a folder of motion files, found the file"), "{error}");
        let error = refuses(&paid(folder.path(), &[command, &["--set", "learn.ppo.epochs"]].concat()));
        assert!(error.contains("such as learn.ppo.epochs=5, found 'learn.ppo.epochs'"), "{error}");
    }
}

#[test]
fn every_term_is_listed_with_its_parameters_as_text_and_json() {
    let folder = tempfile::tempdir().expect("folder");
    let text = succeeds(&paid(folder.path(), &["task", "terms"]));
    assert!(text.contains("foot_sep [m], frame: world") && text.contains("distance_m = 0.24 [m]"), "{text}");
    let table = json(&succeeds(&paid(folder.path(), &["task", "terms", "--json"])));
    let table = table.as_array().expect("a list");
    let fallen = table.iter().find(|t| t["name"] == "fallen").expect("a term");
    assert_eq!(
        (&fallen["kind"], &fallen["parameters"][1]["name"]),
        (&json("\"termination\""), &json("\"tilt_deg\""))
    );
}

#[test]
fn agents_report_every_reward_and_observation_term() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    for (agent, preset) in [("zero", "stage1"), ("random", "stage2")] {
        let args =
            ["agent", agent, "--preset", preset, "--motions", "motions", "--steps", "20", "--envs", "16"];
        let text = succeeds(&paid(folder.path(), &args));
        assert!(text.contains("reward/body_pos") && text.contains("projected_gravity"), "{text}");
        let report = json(&succeeds(&paid(folder.path(), &[&args[..], &["--json"]].concat())));
        assert!(report["metrics"]["reward/total"].is_f64(), "{report}");
        for (group, terms) in [("policy_observation", 10), ("critic_observation", 13)] {
            let list = report[group].as_array().expect("a list");
            assert_eq!(list.len(), terms);
            assert!(
                list.iter().all(|t| t["mean"].is_f64() && t["min"].as_f64() <= t["max"].as_f64()),
                "{list:?}"
            );
        }
        let gravity = report["policy_observation"][2].clone();
        assert_eq!(gravity["name"], "projected_gravity");
        assert!(gravity["min"].as_f64() < Some(-0.7), "{gravity}");
    }
}

#[test]
fn a_trained_policy_is_exported_and_acts() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let train =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "2", "--out", "run", "--json"]);
    let lines = succeeds(&paid(folder.path(), &train));
    let iterations: Vec<_> = lines.lines().map(|line| json(line)["iteration"].clone()).collect();
    assert_eq!(iterations, [1, 2]);
    let metrics = fs::read_to_string(folder.path().join("run/metrics.jsonl")).expect("metrics");
    assert_eq!(metrics.lines().map(json).count(), 2);

    // The run folder holds the policy already; it acts the same.
    let own = OnnxPolicy::load(&folder.path().join("run/policy.onnx")).expect("a policy");
    let text = succeeds(&paid(folder.path(), &["export", "run", "--out", "policy.onnx", "--license", "CC0"]));
    assert!(text.contains("policy.onnx") && text.contains("CC0") && text.contains("model_2"), "{text}");
    let policy = OnnxPolicy::load(&folder.path().join("policy.onnx")).expect("a policy");
    assert_eq!((policy.contract().license.as_str(), policy.contract().joints.len()), ("CC0", 29));
    let mut state = policy.initial_state();
    let actions = policy.act(&vec![0.1; policy.contract().observation_size()], &mut state).expect("acts");
    let same = own.act(&vec![0.1; 160], &mut own.initial_state()).expect("acts");
    assert_eq!(actions, same);
    assert!(actions.iter().all(|a| a.is_finite()) && actions.iter().any(|a| *a != 0.0), "{actions:?}");

    let error = refuses(&paid(folder.path(), &["export", "run", "--out", "nowhere/policy.onnx"]));
    assert!(error.contains("nowhere/policy.onnx") && !error.contains(".part"), "{error}");
    let error = refuses(&paid(folder.path(), &["export", "run", "--average", "99"]));
    assert!(error.contains("run: expected at least 99 checkpoints, found"), "{error}");

    // The small checkpoint acts as the whole one does, and holds nothing of the motions.
    let args = ["export", "run", "--out", "again.onnx", "--checkpoint", "small.safetensors"];
    succeeds(&paid(folder.path(), &args));
    let small = Checkpoint::load(&folder.path().join("small.safetensors")).expect("a checkpoint");
    assert_eq!(small.blob_names(), ["preset.toml"]);
    succeeds(&paid(folder.path(), &["export", "small.safetensors", "--out", "small.onnx"]));
    let small = OnnxPolicy::load(&folder.path().join("small.onnx")).expect("a policy");
    assert_eq!(small.act(&vec![0.1; 160], &mut small.initial_state()).expect("acts"), same);

    let args =
        ["export", "run", "--out", "with.onnx", "--with-reference", "motions/swing_left.npz", "--json"];
    let written = json(&succeeds(&paid(folder.path(), &args)));
    assert_eq!(written["contract"]["reference"], "swing_left");
    let policy = OnnxPolicy::load(&folder.path().join("with.onnx")).expect("a policy");
    assert_eq!(policy.reference(3).expect("runs").len(), 6);
}

#[test]
fn stage_two_starts_from_stage_one_and_a_run_resumes() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let one =
        small(&["train", "stage1", "--motions", "motions", "--iterations", "1", "--out", "one", "--quiet"]);
    succeeds(&paid(folder.path(), &one));
    let two =
        ["train", "stage2", "--motions", "motions", "--iterations", "1", "--out", "two", "--from", "one"];
    assert_eq!(succeeds(&paid(folder.path(), &small(&[&two[..], &["--quiet"]].concat()))), "");
    let resume = ["train", "stage2", "--resume", "--iterations", "2", "--out", "two", "--json"];
    let lines = succeeds(&paid(folder.path(), &resume));
    let iterations: Vec<_> = lines.lines().map(|line| json(line)["iteration"].clone()).collect();
    assert_eq!(iterations, [2]);
    assert!(folder.path().join("two/model_2.safetensors").is_file());
}

// Slow: trains twice and measures contacts, because only a policy that kicks has contacts to measure.
#[test]
fn a_training_keeps_the_measured_contacts_in_its_policy_file() {
    let folder = tempfile::tempdir().expect("folder");
    let few = ["--iterations", "1", "--quiet", "--set", "run.envs=32", "--set", "run.shards=2"];
    succeeds(&paid(folder.path(), &[&["train", "stage2", "--out", "fresh"][..], &few].concat()));
    // The demo's actor next to a critic: it kicks already, and one iteration does not change that.
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../policies/demo/policy.onnx");
    let demo = paid_train::TrainedPolicy::load(demo.as_ref()).expect("the demo").policy;
    let fresh = Checkpoint::load(&folder.path().join("fresh/model_1.safetensors")).expect("a checkpoint");
    let mut file = fresh.tensors().clone();
    for tensor in demo.net.layout().tensors() {
        file.put_f32s(format!("actor.{}", tensor.name), &tensor.shape, &demo.params[tensor.range.clone()]);
    }
    let log_std: Vec<f32> = demo.std.iter().map(|std| std.ln()).collect();
    file.put_f32s("actor.log_std".to_owned(), &[log_std.len()], &log_std);
    // A policy file keeps mean and deviation: here they are of as many samples as a training has, so that one iteration does not move them.
    let moments = demo.normalizer.moments();
    let (count, m2) = (1e8 * moments.count, moments.m2.iter().map(|m2| 1e8 * m2).collect::<Vec<_>>());
    for (name, values) in [("mean", &moments.mean), ("m2", &m2), ("count", &vec![count])] {
        file.put_f64s(format!("normalizer.policy.{name}"), &[values.len()], values);
    }
    file.path = folder.path().join("start.safetensors");
    file.save().expect("writes");
    let train = ["train", "stage2", "--from", "start.safetensors", "--out", "run"];
    succeeds(&paid(folder.path(), &[&train[..], &few].concat()));
    let kept = paid_train::TrainedPolicy::load(&folder.path().join("run/policy.onnx")).expect("a policy");
    let play = kept.preset.task.play();
    assert!(play.contact_s.len() > 6, "{play:?}");
    let file = OnnxPolicy::load(&folder.path().join("run/policy.onnx")).expect("a policy");
    let found = file.contract().play.clone().expect("how it is played");
    assert!(found.contact_s.keys().eq(play.contact_s.keys()), "{found:?}");
    assert_eq!(found.mirror_left_kicks, play.mirror_left_kicks);
    assert_eq!(found.where_it_lay, play.where_it_lay);
    // Their decimals may be rounded.
    assert!(
        found.contact_s.iter().all(|(name, time)| (time - play.contact_s[name]).abs() < 1e-9),
        "{found:?}"
    );
}

// Slow: trains two stages, scores them and resumes, because one command does all of it.
#[test]
fn one_command_trains_both_stages_and_scores_them_and_resuming_goes_on_with_the_second() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let second = "base = \"stage2\"\nstage = \"stage2\"\n[task.sampling]\nmiss_sampling_weight = 0.25\n";
    fs::write(folder.path().join("second.toml"), second).expect("a preset");
    succeeds(&paid(
        folder.path(),
        &small(&[
            "train",
            "--motions",
            "motions",
            "--iterations",
            "1",
            "--quiet",
            "--stage2-preset",
            "second.toml",
        ]),
    ));
    let preset = fs::read_to_string(folder.path().join("runs/stage2/preset.toml")).expect("a preset");
    assert!(preset.contains("miss_sampling_weight = 0.25"), "{preset}");
    for file in [
        "stage1/policy.onnx",
        "stage2/policy.onnx",
        "eval/builtin_tracking.json",
        "eval/builtin_rolling_shooting.json",
    ] {
        assert!(folder.path().join("runs").join(file).is_file(), "{file}");
    }
    let text = succeeds(&paid(folder.path(), &["train", "--resume", "--iterations", "2", "--json"]));
    let first = json(text.lines().next().expect("a line"));
    assert_eq!((first["stage"].as_str(), first["iteration"].as_u64()), (Some("stage2"), Some(2)));
    assert!(!folder.path().join("runs/stage1/model_2.safetensors").exists());
}

#[test]
fn both_stages_say_once_which_clips_are_doubtful_and_refuse_bad_ones_of_the_second_before_the_first() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let both = ["train", "--motions", "motions", "--iterations", "1"];
    // Stage II cannot make its folder, so nothing is scored.
    fs::create_dir(folder.path().join("runs")).expect("a folder");
    fs::write(folder.path().join("runs/stage2"), "").expect("a file");
    let error = refuses(&paid(folder.path(), &small(&both)));
    assert_eq!(error.matches("note: motions: 2 of 2 clips fail `paid motion check`").count(), 1, "{error}");
    assert!(folder.path().join("runs/stage1/policy.onnx").is_file(), "{error}");

    let mut clip = swing(KickLeg::Left);
    clip.joint_pos.iter_mut().for_each(|q| *q = q.to_degrees());
    fs::create_dir(folder.path().join("other")).expect("a folder");
    let path = folder.path().join("other/degrees.npz");
    write_npz(&path, &clip, &RobotModel::g1(), &RobotSpec::g1()).expect("a clip");
    let second = "base = \"stage2\"\nstage = \"stage2\"\n[run]\nmotions = \"other\"\n";
    fs::write(folder.path().join("second.toml"), second).expect("a preset");
    let both = ["train", "--iterations", "1", "--out", "bad", "--stage2-preset", "second.toml", "--quiet"];
    let error = refuses(&paid(folder.path(), &small(&both)));
    assert!(error.contains("degrees.npz") && error.contains("these look like degrees"), "{error}");
    assert!(!folder.path().join("bad").exists());
}

#[test]
fn benchmarks_print_json() {
    let folder = tempfile::tempdir().expect("folder");
    write_motions(folder.path());
    let physics =
        ["bench", "physics", "--no-mujoco", "--seconds", "0.02", "--rounds", "1", "--envs", "16", "--json"];
    json(&succeeds(&paid(folder.path(), &physics)));
    let train =
        ["bench", "train", "--motions", "motions", "--preset", "stage1", "--seconds", "0.05", "--json"];
    let train = [&train[..], &["--envs", "32"], &SMALL].concat();
    let lines = succeeds(&paid(folder.path(), &train));
    assert!(lines.lines().count() > 0);
    lines.lines().for_each(|line| drop(json(line)));
}
