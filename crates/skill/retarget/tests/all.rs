//! The tests of `paid-retarget` as one program: one link instead of one a file. `cargo test -p paid-retarget --test all FILE::` runs a file's.

mod axes;
mod common;
mod human;
mod mocap;
mod mutation;
mod points;
mod unsaid;
