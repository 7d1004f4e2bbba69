//! `mpirun -n 2 paid train`: two processes train what one trains.

#[cfg(target_os = "linux")]
mod killed;
mod refused;

use std::path::Path;
use std::process::{Command, Output};

use crate::common::{paid, succeeds};
use serde_json::Value;

/// A run of seconds. Products in single precision: bfloat16 weights that round the other way would hide a mistake.
const RUN: [&str; 18] = [
    "train",
    "stage1",
    "--json",
    "--threads",
    "1",
    "--iterations",
    "2",
    "--set",
    "run.envs=64",
    "--set",
    "run.shards=2",
    "--set",
    "learn.precision=f32",
    "--set",
    "learn.ppo.balanced=true",
    "--set",
    "phases=[]",
    "--out",
];

/// Starts a command of `mpirun`; `None` where there is none.
fn mpirun(folder: &Path, args: &[&str]) -> Option<Output> {
    command(folder, args).output().ok()
}

fn command(folder: &Path, args: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command.current_dir(folder).args(["--oversubscribe", "--bind-to", "none"]).args(args);
    // Those who test in containers are root.
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1").env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    command
}

fn losses(text: &str) -> Vec<[f64; 3]> {
    let records = text.lines().map(|line| serde_json::from_str::<Value>(line).expect("a record"));
    let number = |value: &Value| value.as_f64().expect("a number");
    records
        .map(|r| [number(&r["mean_reward"]), number(&r["loss"]["kl"]), number(&r["loss"]["value_function"])])
        .collect()
}

#[test]
fn two_processes_train_what_one_trains() {
    let folder = tempfile::tempdir().expect("folder");
    let two: Vec<&str> =
        ["-n", "2", env!("CARGO_BIN_EXE_paid")].into_iter().chain(RUN).chain(["two"]).collect();
    let Some(output) = mpirun(folder.path(), &two) else {
        paid_testing::without_program("two_processes_train_what_one_trains", "mpirun");
        return;
    };
    let found = losses(&succeeds(&output));
    let one: Vec<&str> = RUN.into_iter().chain(["one"]).collect();
    let expected = losses(&succeeds(&paid(folder.path(), &one)));
    assert_eq!((found.len(), expected.len()), (2, 2), "the first rank prints, the other one is silent");
    for (a, b) in found.iter().flatten().zip(expected.iter().flatten()) {
        assert!((a - b).abs() <= 1e-4 * b.abs(), "{a}, alone {b}");
    }
    for name in ["model_2.safetensors", "policy.onnx"] {
        assert!(folder.path().join("two").join(name).is_file(), "{name}");
    }
    // One process continues where two have stopped.
    let resume = [
        "train",
        "stage1",
        "--out",
        "two",
        "--resume",
        "--set",
        "run.iterations=3",
        "--threads",
        "1",
        "--quiet",
    ];
    let text = succeeds(&paid(folder.path(), &resume));
    assert_eq!(text, "");
}

/// A method with one small iteration, and a policy that there is: these programs are not optimized.
const PLAN: &str = r#"
    title = "shared out"
    samples = 384
    sets = ["run.envs=16", "run.shards=1", "learn.ppo.minibatches=1", "learn.precision=\"f32\""]

    [judge]
    trials = 1
    grid_step_m = 2.0
    limit_s = 0.2

    [[entry]]
    name = "Without clips"
    stages = [{ preset = "pure_rl" }]

    [[entry]]
    name = "What there is"
    policy = "DEMO"
"#;

#[test]
fn two_processes_share_the_entries_of_a_plan_out() {
    let test = "two_processes_share_the_entries_of_a_plan_out";
    let Some(_) = paid_testing::mujoco(test, paid_mujoco::Library::get()) else { return };
    let folder = tempfile::tempdir().expect("folder");
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../policies/demo/policy.onnx");
    std::fs::write(folder.path().join("plan.toml"), PLAN.replace("DEMO", demo)).expect("writes");
    let line = ["compare", "plan.toml", "--threads", "1", "--out"];
    let two: Vec<&str> =
        ["-n", "2", env!("CARGO_BIN_EXE_paid")].into_iter().chain(line).chain(["two"]).collect();
    let Some(output) = mpirun(folder.path(), &two) else {
        paid_testing::without_program(test, "mpirun");
        return;
    };
    let table = succeeds(&output);
    // Each was scored by one of them, and one process continues with what they left.
    let said = String::from_utf8_lossy(&output.stderr);
    for name in ["1 of 2: Without clips, seed 1, Truth", "2 of 2: What there is, Truth"] {
        assert_eq!(said.matches(name).count(), 1, "{said}");
    }
    let alone: Vec<&str> = line.into_iter().chain(["two"]).collect();
    let again = paid(folder.path(), &alone);
    assert_eq!(table, succeeds(&again));
    assert!(!String::from_utf8_lossy(&again.stderr).contains("iterations"), "nothing is trained again");
    let page = std::fs::read_to_string(folder.path().join("two/report.html")).expect("a page");
    assert!(page.contains("Without clips") && page.contains("What there is"), "{page}");
}

#[test]
fn two_processes_share_the_trials_of_an_evaluation_out() {
    let test = "two_processes_share_the_trials_of_an_evaluation_out";
    let folder = tempfile::tempdir().expect("folder");
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../policies/demo/policy.onnx");
    // Two batches of 64.
    let shoot = ["eval", "shooting", "--policy", demo, "--effective", "--trials", "2", "--limit", "0.4"];
    let of = |more: &[&'static str]| -> Vec<&str> { shoot.iter().chain(more).copied().collect() };
    let quiet = of(&["--engine", "builtin", "--threads", "1", "--json"]);
    let two: Vec<&str> = ["-n", "2", env!("CARGO_BIN_EXE_paid")].into_iter().chain(quiet.clone()).collect();
    let Some(output) = mpirun(folder.path(), &two) else {
        paid_testing::without_program(test, "mpirun");
        return;
    };
    let report = |text: String| -> Value {
        let mut report: Value = serde_json::from_str(&text).expect("one report");
        let timing = report.as_object_mut().expect("an object").remove("timing").expect("a timing");
        assert_eq!(timing["trials"], 126);
        report
    };
    assert_eq!(report(succeeds(&output)), report(succeeds(&paid(folder.path(), &quiet))));

    // What is refused reads the policy for MuJoCo first.
    if paid_testing::mujoco(test, paid_mujoco::Library::get()).is_none() {
        return;
    }
    let contacts = ["eval", "contacts", "--policy", demo];
    let both = of(&["--engine", "both"]);
    for (command, expected) in
        [(&contacts[..], "expected one process for this evaluation"), (&both, "expected one engine")]
    {
        let command: Vec<&str> =
            ["-n", "2", env!("CARGO_BIN_EXE_paid")].into_iter().chain(command.to_vec()).collect();
        let refused = mpirun(folder.path(), &command).expect("it is there");
        assert!(!refused.status.success());
        let said = String::from_utf8_lossy(&refused.stderr);
        assert!(said.contains(expected), "{said}");
    }
}
