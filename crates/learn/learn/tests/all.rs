//! The tests of `paid-learn` as one program: one link instead of one a file. `cargo test -p paid-learn --test all FILE::` runs a file's.

mod bf16;
mod checkpoints;
mod common;
mod gradients;
mod learning;
mod seams;
mod teacher;
