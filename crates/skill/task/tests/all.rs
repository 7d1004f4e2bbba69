//! The tests of `paid-task` as one program: one link instead of one a file. `cargo test -p paid-task --test all FILE::` runs a file's.

mod engine;
mod mirror;
mod perceived;
mod playback;
mod prediction;
mod without_reference;
