//! The option `--threads`.

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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_number_of_threads_that_no_system_starts_is_refused() {
        assert_eq!(thread_count(Some(MOST)).expect("allowed"), MOST);
        let error = thread_count(Some(99_999_999)).expect_err("refused").to_string();
        assert_eq!(error, "--threads: expected 1 to 1024, found 99999999");
    }
}
