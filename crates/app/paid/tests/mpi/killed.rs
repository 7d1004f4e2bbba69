//! A rank that dies in the middle of a training.

use std::process::Child;
use std::time::Duration;

use paid_train::folder::checkpoints;

use crate::command;
use crate::common::{kill, paid, small, succeeds};

/// The process of this rank among those that `mpirun` has started.
fn process_of(mpirun: u32, rank: &str) -> Option<u32> {
    let is_rank = |pid: &u32| {
        let read = |file: &str| std::fs::read(format!("/proc/{pid}/{file}")).unwrap_or_default();
        // The name, which may contain anything, ends with the last bracket; then come state and parent.
        let stat = String::from_utf8_lossy(&read("stat")).into_owned();
        let parent = stat.rsplit(')').next().and_then(|rest| rest.split_whitespace().nth(1)?.parse().ok());
        let variable = format!("OMPI_COMM_WORLD_RANK={rank}");
        parent == Some(mpirun)
            && read("environ").split(|byte| *byte == 0).any(|text| text == variable.as_bytes())
    };
    let all = std::fs::read_dir("/proc").ok()?.flatten();
    all.filter_map(|entry| entry.file_name().to_str()?.parse().ok()).find(is_rank)
}

/// A job that is killed when its test ends, however it ends.
struct Job(Child);

impl Drop for Job {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn a_rank_that_is_killed_ends_the_job_and_the_last_checkpoint_goes_on() {
    let test = "a_rank_that_is_killed_ends_the_job_and_the_last_checkpoint_goes_on";
    let folder = tempfile::tempdir().expect("folder");
    let run = folder.path().join("run");
    let train =
        small(&["train", "stage1", "--threads", "1", "--quiet", "--out", "run", "--set", "phases=[]"]);
    let endless = ["--iterations", "1000000"];
    let args = [&["-n", "2", env!("CARGO_BIN_EXE_paid")], &train[..], &endless].concat();
    let said = std::fs::File::create(folder.path().join("said")).expect("a file");
    let Ok(job) = command(folder.path(), &args).stderr(said).spawn() else {
        paid_testing::without_program(test, "mpirun");
        return;
    };
    let mut job = Job(job);
    let said = || std::fs::read_to_string(folder.path().join("said")).expect("a file");
    let newest = || Some(checkpoints(&run).ok()?.pop()?.0);
    while newest().is_none() {
        assert!(job.0.try_wait().expect("a job").is_none(), "ended before its first checkpoint: {}", said());
        std::thread::sleep(Duration::from_millis(20));
    }
    kill("-KILL", process_of(job.0.id(), "1").expect("the second rank"));

    assert!(!job.0.wait().expect("it ends").success());
    let said = said();
    assert!(said.contains("rank 1") && said.contains("signal 9"), "{said}");

    let last = newest().expect("a checkpoint");
    let next = format!("run.iterations={}", last + 1);
    let resume = ["train", "stage1", "--out", "run", "--resume", "--set", &next, "--threads", "1", "--quiet"];
    succeeds(&paid(folder.path(), &resume));
    assert_eq!(newest(), Some(last + 1));
}
