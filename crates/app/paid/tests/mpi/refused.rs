//! Ranks that would not do the same work: the job ends before anything is written, with one error that names rank and machine.

use std::path::Path;
use std::process::Command;

use paid_motion::KickLeg;

use crate::common::{swing, write_clip};
use crate::{PLAN, RUN, mpirun};

/// The error of two ranks that are refused: it is printed once, and nothing is written to `out`.
fn refused(folder: &Path, out: &str, ranks: [&[&str]; 2]) -> Option<String> {
    let output = mpirun(folder, &[&["-n", "1"][..], ranks[0], &[":", "-n", "1"], ranks[1]].concat())?;
    let error = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!output.status.success(), "{error}");
    assert_eq!(error.matches("error: ").count(), 1, "{error}");
    assert!(!folder.join(out).exists(), "nothing is written: {error}");
    Some(error)
}

/// The name of this machine, as MPI reports it.
fn host() -> String {
    let output = Command::new("uname").arg("-n").output().expect("a name");
    String::from_utf8_lossy(&output.stdout).trim().to_owned()
}

#[test]
fn a_rank_that_would_train_something_else_is_refused_by_its_number_and_machine() {
    let test = "a_rank_that_would_train_something_else_is_refused_by_its_number_and_machine";
    let folder = tempfile::tempdir().expect("folder");
    let path = folder.path();
    let program = env!("CARGO_BIN_EXE_paid");
    let of = |program, more: &[&'static str]| [&[program], &RUN[..], &["other"], more].concat();
    let rank = |more: &[&'static str]| of(program, more);
    let host = host();

    // Another preset.
    let Some(error) = refused(path, "other", [&rank(&[]), &rank(&["--set", "learn.ppo.epochs=3"])]) else {
        paid_testing::without_program(test, "mpirun");
        return;
    };
    let expected = format!(
        "error: rank 1 on {host}: expected '[learn.ppo] epochs = 1', as rank 0 on {host} has, found '[learn.ppo] epochs = 3'"
    );
    assert!(error.contains(&expected), "{error}");

    // Another instruction set: every machine has `portable`.
    let error = refused(path, "other", [&rank(&[]), &rank(&["--set", "run.isa=portable"])]).expect("runs");
    let set =
        if paid_lanes::Isa::detect() == paid_lanes::Isa::Portable { "run.isa" } else { "instruction set" };
    assert!(error.contains(&format!("rank 1 on {host}: expected '{set}")) || set == "run.isa", "{error}");
    assert!(error.contains("portable"), "{error}");

    // Another program: the same one with a byte after its end, which is not read.
    let copy = path.join("paid");
    let mut bytes = std::fs::read(program).expect("the program");
    let length = bytes.len();
    bytes.push(0);
    std::fs::write(&copy, &bytes).expect("writes");
    std::fs::set_permissions(&copy, std::fs::metadata(program).expect("there").permissions())
        .expect("may run");
    let copy = copy.to_string_lossy();
    let error = refused(path, "other", [&rank(&[]), &of(&copy, &[])]).expect("runs");
    let expected = format!("rank 1 on {host}: expected 'program of {length} bytes, CRC-32C ");
    assert!(error.contains(&expected), "{error}");
    assert!(error.contains(&format!("found 'program of {} bytes, CRC-32C ", length + 1)), "{error}");

    // Other motions under the same path: as if each machine had its own disk.
    for (name, leg) in [("a", KickLeg::Left), ("b", KickLeg::Left)] {
        std::fs::create_dir(path.join(name)).expect("a folder");
        let mut clip = swing(leg);
        if name == "b" {
            clip.joint_pos[0] += 1e-3;
        }
        write_clip(&path.join(name), &clip);
    }
    let [a, b] = ["a", "b"].map(|disk| [&["-wdir", disk], &rank(&["--motions", "motions"])[..]].concat());
    let error = refused(path, "a/other", [&a, &b]).expect("runs");
    assert!(error.contains(&format!("rank 1 on {host}: expected 'motion 'swing', ")), "{error}");
    refused(path, "b/other", [&b, &a]).expect("runs");
}

#[test]
fn a_rank_that_would_judge_something_else_is_refused_by_its_number_and_machine() {
    let test = "a_rank_that_would_judge_something_else_is_refused_by_its_number_and_machine";
    let folder = tempfile::tempdir().expect("folder");
    let (path, host) = (folder.path(), host());
    let demo = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../policies/demo/policy.onnx");
    let shoot = [
        env!("CARGO_BIN_EXE_paid"),
        "eval",
        "shooting",
        "--policy",
        demo,
        "--trials",
        "1",
        "--out",
        "scores",
    ];
    let rank = |more: &[&'static str]| [&shoot[..], more].concat();
    let Some(error) = refused(path, "scores", [&rank(&[]), &rank(&["--isa", "portable", "--limit", "3"])])
    else {
        paid_testing::without_program(test, "mpirun");
        return;
    };
    assert!(error.contains(&format!("error: rank 1 on {host}: expected '")), "{error}");
    let error = refused(path, "scores", [&rank(&["--limit", "2"]), &rank(&["--limit", "3"])]).expect("runs");
    assert!(error.contains("found 'limit_s: 3.0,'"), "{error}");

    if paid_testing::mujoco(test, paid_mujoco::Library::get()).is_none() {
        return;
    }
    for (name, samples) in [("one.toml", "384"), ("two.toml", "768")] {
        let plan = PLAN.replace("DEMO", demo).replace("384", samples);
        std::fs::write(path.join(name), plan).expect("writes");
    }
    let rank = |plan| [env!("CARGO_BIN_EXE_paid"), "compare", plan, "--threads", "1", "--out", "table"];
    let error = refused(path, "table", [&rank("one.toml"), &rank("two.toml")]).expect("runs");
    assert!(error.contains("expected 'samples: 384,', as rank 0 on "), "{error}");
    assert!(error.contains("found 'samples: 768,'"), "{error}");
}
