//! The trainer on the real task, robot and motions: seconds of Stage I.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use paid_train::{Alone, End, Limits, Outcome, RunPreset, StageJob, Start, train_stage};

/// The folder of the release's motions, or `None` (the test is skipped).
fn motions(test: &str) -> Option<PathBuf> {
    paid_testing::shared_data(test, "data/motions/paid/standard")
}

fn preset(stage: &str, motions: &std::path::Path) -> RunPreset {
    let mut sets = vec![
        "run.envs=64".to_owned(),
        "run.shards=4".to_owned(),
        "run.iterations=5".to_owned(),
        "run.checkpoint_interval=3".to_owned(),
        "learn.ppo.minibatches=2".to_owned(),
        format!("run.motions={:?}", motions.to_string_lossy()),
    ];
    if stage == "recurrent" {
        let teacher =
            std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx");
        sets.push(format!("teacher.policy={:?}", teacher.to_string_lossy()));
    }
    RunPreset::resolve(stage, &sets).expect("preset")
}

/// Trains in `out`; with `stop_after` as after Ctrl-C in that iteration.
fn run(out: PathBuf, preset: &RunPreset, start: Start, threads: usize, stop_after: u64) -> Outcome {
    let job = StageJob {
        preset: preset.clone(),
        out,
        start,
        limits: Limits::default(),
        threads,
        ranks: Arc::new(Alone),
    };
    let stop = AtomicBool::new(false);
    train_stage(&job, &stop, &mut |record| {
        assert!(record.rewards.get("total").is_some_and(f64::is_finite));
        stop.store(record.iteration >= stop_after, Ordering::SeqCst);
    })
    .expect("trains")
}

fn weights(outcome: &Outcome) -> Vec<f32> {
    let checkpoint = paid_learn::Checkpoint::load(&outcome.checkpoint).expect("reads");
    checkpoint.policy().expect("policy").params
}

#[test]
fn threads_and_interruptions_do_not_change_the_weights() {
    let Some(motions) = motions("threads_and_interruptions_do_not_change_the_weights") else { return };
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    for (stage, phases) in [("stage1", [0, 1]), ("stage2", [1, 2]), ("recurrent", [1, 2])] {
        let preset = preset(stage, &motions);
        let one = run(at(&format!("{stage}-one")), &preset, Start::Fresh, 1, u64::MAX);
        assert_eq!((one.end, one.samples), (End::Done, 5 * 64 * 24));
        // A phase of every preset begins after three iterations, between the two interruptions; in Stage II with longer delays.
        assert_eq!([0.4, 0.6].map(|share| preset.phase(share)), phases);
        for stop_after in [2, 4] {
            let out = at(&format!("{stage}-{stop_after}"));
            let stopped = run(out.clone(), &preset, Start::Fresh, 2, stop_after);
            assert_eq!((stopped.end, stopped.iteration), (End::Stopped, stop_after));
            let two = run(out, &preset, Start::Resume, 2, u64::MAX);
            assert_eq!((two.end, two.iteration), (End::Done, 5));
            assert_eq!(weights(&one), weights(&two), "{stage}, stopped after {stop_after}");
        }
    }
}

#[test]
fn the_papers_presets_train_as_they_stand() {
    let folder = tempfile::tempdir().expect("folder");
    for name in ["paper_stage1", "paper_stage2"] {
        // Smaller, and on the built-in kicks.
        let sets = ["run.envs=64", "run.shards=4", "run.iterations=1"].map(str::to_owned);
        let preset = RunPreset::resolve(name, &sets).expect("resolves");
        let outcome = run(folder.path().join(name), &preset, Start::Fresh, 2, u64::MAX);
        assert_eq!((outcome.end, outcome.samples), (End::Done, 64 * 24));
    }
}

// Slow: trains three presets twice, because a resumed run must end in the same weights.
#[test]
fn baselines_train_as_they_stand_and_a_style_reward_survives_an_interruption() {
    let folder = tempfile::tempdir().expect("folder");
    let sets = ["run.envs=64", "run.shards=4", "run.iterations=4", "run.checkpoint_interval=1"];
    for name in ["pure_rl", "single_stage", "amp"] {
        let preset = RunPreset::resolve(name, &sets.map(str::to_owned)).expect("resolves");
        let one = run(folder.path().join(name), &preset, Start::Fresh, 1, u64::MAX);
        assert_eq!((one.end, one.samples), (End::Done, 4 * 64 * 24), "{name}");
        let out = folder.path().join(format!("{name}-again"));
        let stopped = run(out.clone(), &preset, Start::Fresh, 2, 2);
        assert_eq!(stopped.end, End::Stopped);
        let two = run(out.clone(), &preset, Start::Resume, 2, u64::MAX);
        assert_eq!(weights(&one), weights(&two), "{name}");
        let log = std::fs::read_to_string(out.join("metrics.jsonl")).expect("a log");
        assert_eq!(log.contains("style/told_apart"), name == "amp", "{name}");
    }
}

/// The second stage changes the scene and what is seen of it, and nothing of what is paid.
#[test]
fn pure_rl_continues_in_scenes_that_are_randomized_as_those_of_stage2() {
    let folder = tempfile::tempdir().expect("folder");
    let sets = ["run.envs=64", "run.shards=4", "run.iterations=2", "run.checkpoint_interval=1"];
    let resolve = |name: &str| RunPreset::resolve(name, &sets.map(str::to_owned)).expect("resolves");
    let (first, second) = (resolve("pure_rl"), resolve("pure_rl_scattered"));
    assert_eq!(first.task.rewards, second.task.rewards);
    assert_eq!(first.task.observations.policy, second.task.observations.policy);
    let ours = &resolve("stage2").phases[0].values["task"];
    let own = toml::Value::try_from(&second.task).expect("TOML");
    for table in ["randomization", "eyes"] {
        for (key, value) in ours[table].as_table().expect("a table") {
            let own = &own[table][key];
            // Of the odometry stage2 changes some keys.
            match value.as_table() {
                Some(keys) => assert!(keys.iter().all(|(k, v)| own.get(k) == Some(v)), "{key}"),
                None => assert_eq!(own, value, "{key}"),
            }
        }
    }
    run(folder.path().join("one"), &first, Start::Fresh, 2, u64::MAX);
    let two = run(folder.path().join("two"), &second, Start::From(folder.path().join("one")), 2, u64::MAX);
    assert_eq!((two.end, two.samples), (End::Done, 2 * 64 * 24));
}

#[test]
fn a_style_reward_and_what_it_sees_go_together() {
    let refused =
        |name: &str, set: &str| RunPreset::resolve(name, &[set.to_owned()]).expect_err("refused").to_string();
    let error = refused("stage1", r#"task.observations.style=["joint_vel"]"#);
    assert!(error.contains("task.observations.style: expected none without [amp], found some"), "{error}");
    let error = refused("amp", "task.observations.style=[]");
    assert!(error.contains("task.observations.style: expected terms for [amp], found none"), "{error}");
    let error = refused("amp", r#"task.observations.style=["last_action"]"#);
    assert!(error.contains("terms that clips have, which have no actions"), "{error}");
    let error = refused("amp", "amp.discriminator.batch=0");
    assert!(error.contains("amp.discriminator.batch: expected one or more, found 0"), "{error}");
}

/// A policy that sees where the ball is, with a memory of its last terms; the critic is given where the ball will be, as in `stage2`.
const MEMORY: &str = r#"
base = "stage2"

[learn.actor]
kind = "memory"
hidden = [256, 128, 64]
lstm = { layers = 1, size = 48, inputs = 15 }

[task.observations]
policy = [
    "reference_joint_pos", "reference_joint_vel", "joint_pos_rel", "joint_vel", "last_action",
    "projected_gravity", "reference_anchor_ang_vel", "base_ang_vel", "ball_pos", "goal_pos",
]
"#;

#[test]
fn a_memory_is_trained_from_a_policy_without_one() {
    let Some(motions) = motions("a_memory_is_trained_from_a_policy_without_one") else { return };
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let one = run(at("mlp"), &preset("stage2", &motions), Start::Fresh, 2, 1);
    std::fs::write(at("memory.toml"), MEMORY).expect("writes");
    let memory = preset(&at("memory.toml").to_string_lossy(), &motions);
    let whole = run(at("whole"), &memory, Start::From(at("mlp")), 2, u64::MAX);
    // The first hidden layer's bias comes from there, and 48 more columns.
    let sizes = [&one, &whole].map(|run| weights(run).len());
    assert_eq!(sizes[1] - sizes[0], 48 * 256 + 4 * 48 * (15 + 48 + 1));
    let parts = at("parts");
    run(parts.clone(), &memory, Start::From(at("mlp")), 1, 2);
    let resumed = run(parts, &memory, Start::Resume, 2, u64::MAX);
    assert_eq!(weights(&resumed), weights(&whole));
}

#[test]
fn stage_two_starts_from_the_networks_of_stage_one() {
    let Some(motions) = motions("stage_two_starts_from_the_networks_of_stage_one") else { return };
    let folder = tempfile::tempdir().expect("folder");
    let first = preset("stage1", &motions);
    let one = run(folder.path().join("one"), &first, Start::Fresh, 2, 1);
    let mut second = preset("stage2", &motions);
    let ppo = &mut second.learn.ppo;
    (ppo.initial_std, ppo.max_std) = (0.2, 0.3);
    let scene = paid_train::Scene::load(&second).expect("scene");
    let shards = scene.shards(&second).expect("shards");
    let mut trainer = paid_train::Trainer::new(&second, shards, scene.motion_names()).expect("trainer");
    let before = paid_learn::Checkpoint::load(&one.checkpoint).expect("reads");
    trainer.start_from(&before).expect("starts");
    assert_eq!(trainer.learner().actor().weights(), weights(&one));
    assert_eq!(trainer.progress().iteration, 0);
    let record = trainer.iterate(2).expect("iterates");
    assert_eq!((record.iteration, record.stage.as_str()), (1, "stage2"));
    // Stage I began at 0.35; the noise is the second preset's.
    assert!((record.mean_noise_std - 0.2).abs() < 0.02, "{}", record.mean_noise_std);
}

/// A student that is its teacher acts as it does: what the shards show the teacher is what they show the policy, in the
/// mirror too.
#[test]
fn a_teacher_sees_what_its_policy_sees_and_a_student_learns_from_it() {
    let folder = tempfile::tempdir().expect("folder");
    let at = |name: &str| folder.path().join(name);
    let resolve = |name: &str, sets: &[&str]| {
        let common = ["run.envs=64", "run.shards=4", "run.iterations=2", "learn.precision=f32"];
        let sets: Vec<String> = common.iter().chain(sets).map(|set| (*set).to_owned()).collect();
        RunPreset::resolve(name, &sets)
    };
    run(at("teacher"), &resolve("stage2", &[]).expect("resolves"), Start::Fresh, 2, u64::MAX);
    let file = at("taught.toml");
    let policy = at("teacher").join("policy.onnx");
    let text = format!(
        "base = \"stage2\"\n[teacher]\npolicy = {:?}\nweight = 1\nuntil = 0.75\n",
        policy.display().to_string()
    );
    std::fs::write(&file, text).expect("writes");
    let taught = |sets: &[&str]| resolve(&file.display().to_string(), sets);
    let losses = |name: &str, preset: &RunPreset, start: Start| -> Vec<f64> {
        run(at(name), preset, start, 2, u64::MAX);
        let log = std::fs::read_to_string(at(name).join("metrics.jsonl")).expect("a log");
        let line = |line: &str| -> serde_json::Value { serde_json::from_str(line).expect("JSON") };
        log.lines().map(|text| line(text)["loss"]["teacher"].as_f64().unwrap_or(0.0)).collect()
    };
    // Without noise, at a rate of next to nothing; in the second iteration it normalizes by other means. Some of 64 environments begin with
    // left-footed kicks.
    let still = taught(&[
        "learn.ppo.learning_rate=1e-9",
        "learn.ppo.adaptive_learning_rate=false",
        "learn.ppo.min_learning_rate=1e-9",
        "task.observations.noise.projected_gravity=0",
        "task.observations.noise.reference_anchor_ang_vel=0",
        "task.observations.noise.base_ang_vel=0",
        "task.observations.noise.joint_pos_rel=0",
        "task.observations.noise.joint_vel=0",
    ]);
    let still = still.expect("resolves");
    let own = losses("own", &still, Start::From(at("teacher")));
    assert!(own[0] > 0.0 && own[0] < 1e-9, "{own:?}");
    // Its file does not say of how few samples its normalizer was made, which further ones move less then.
    let from_file = losses("from_file", &still, Start::From(policy.clone()));
    assert!(
        from_file[0] > 0.0 && from_file[0] < 1e-9 && from_file[1] < own[1] / 2.0,
        "{own:?} {from_file:?}"
    );
    // Another policy has something to learn, which counts as long as the preset says.
    let other = losses("other", &taught(&["run.iterations=5"]).expect("resolves"), Start::Fresh);
    assert!(other[0] > 0.1 && other[3] > 0.0 && other[4] == 0.0, "{other:?}");
    // The file of the student reads without its teacher.
    std::fs::remove_dir_all(at("teacher")).expect("removes");
    paid_train::TrainedPolicy::load(&at("other").join("policy.onnx")).expect("a policy");

    let refused = |set: &str| taught(&[set]).expect_err("refused").to_string();
    let error = refused("teacher.weight=0");
    assert!(error.contains("teacher.weight: expected a positive number, found 0"), "{error}");
    let error = refused("teacher.until=2");
    assert!(error.contains("teacher.until: expected more than 0 and at most 1, found 2"), "{error}");
}
