//! The tests of `paid-runtime` as one program: one link instead of one a file. `cargo test -p paid-runtime --test all FILE::` runs a file's.

mod common;
mod last_words;
mod limits;
mod live;
mod log;
mod refusals;
#[cfg(all(feature = "dds", feature = "perception"))]
mod ros;
#[cfg(feature = "dds")]
mod wire;
