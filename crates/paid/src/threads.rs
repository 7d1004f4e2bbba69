//! The option `--threads`.

use crate::failure::Failure;

/// Worker threads: as asked, or one per core.
pub fn thread_count(asked: Option<usize>) -> Result<usize, Failure> {
    match asked {
        Some(0) => Err(Failure::input("--threads: expected at least 1, found 0")),
        Some(threads) => Ok(threads),
        None => Ok(std::thread::available_parallelism().map_or(1, usize::from)),
    }
}
