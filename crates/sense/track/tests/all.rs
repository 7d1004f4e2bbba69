//! The tests of `paid-track` as one program: one link instead of one a file. `cargo test -p paid-track --test all FILE::` runs a file's.

mod memory;
mod sequences;
mod tracker;
