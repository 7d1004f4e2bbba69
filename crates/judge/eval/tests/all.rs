//! The tests of `paid-eval` as one program: one link instead of one a file. `cargo test -p paid-eval --test all FILE::` runs a file's.

mod common;
#[cfg(feature = "eyes")]
mod eyes;
mod golden;
mod matches;
mod protocols;
mod terrain;
