//! The option `--threads`.

use paid_lanes::Isa;
use paid_train::RunConfig;

use crate::failure::Failure;

/// More than any machine has, and no more than a system starts.
const MOST: usize = 1024;

/// Worker threads: as asked, or one per core.
pub fn thread_count(asked: Option<usize>) -> Result<usize, Failure> {
    match asked {
        Some(threads @ 1..=MOST) => Ok(threads),
        Some(found) => Err(Failure::input(format!("--threads: expected 1 to {MOST}, found {found}"))),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}

/// The note about a run that has no work for some of its threads: each shard uses one thread.
pub fn without_work(threads: usize, run: &RunConfig) -> Option<String> {
    let lanes = run.isa.parse::<Isa>().ok()?.lanes();
    let groups = run.envs / lanes;
    let fits = |shards: &usize| groups.is_multiple_of(*shards);
    let more = (run.shards + 1..=threads).rev().find(fits)?;
    Some(format!(
        "{threads} threads, but the environments are in {} shards, and each shard uses one thread; \
         `--set run.shards={more} --set learn.ppo.slices={more}` uses more (sums are then rounded differently)",
        run.shards
    ))
}

#[cfg(test)]
mod tests {
    use paid_train::RunPreset;

    use super::*;

    #[test]
    fn a_run_whose_shards_leave_threads_without_work_says_how_to_use_them() {
        let run = |sets: &[&str]| {
            let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
            RunPreset::resolve("stage1", &sets).expect("valid").run
        };
        // 1920 environments are 240 groups of eight lanes; 16 shards are 15 groups each.
        let portable = run(&["run.isa=portable"]);
        let said = without_work(16, &portable).expect("eight threads have nothing to do");
        assert!(said.starts_with("16 threads, but the environments are in 8 shards"), "{said}");
        assert!(said.contains("--set run.shards=16 --set learn.ppo.slices=16"), "{said}");
        // Of 240 the largest divisor below 19 is 16.
        assert_eq!(without_work(19, &portable), Some(said.replacen("16", "19", 1)));
        assert_eq!(without_work(8, &portable), None);
        // 9 divides 240 into no whole groups.
        assert_eq!(without_work(9, &portable), None);
        let wanted = run(&["run.isa=portable", "run.shards=16"]);
        assert_eq!(without_work(16, &wanted), None);
    }

    #[test]
    fn a_number_of_threads_that_no_system_starts_is_refused() {
        assert_eq!(thread_count(Some(MOST)).expect("allowed"), MOST);
        let error = thread_count(Some(99_999_999)).expect_err("refused").to_string();
        assert_eq!(error, "--threads: expected 1 to 1024, found 99999999");
    }
}
