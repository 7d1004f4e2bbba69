//! The tests of `paid-train` as one program: one link instead of one a file. `cargo test -p paid-train --test all FILE::` runs a file's.

mod formats;
mod real_task;
