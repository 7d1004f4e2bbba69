//! The tests of `paid-policy` as one program: one link instead of one a file. `cargo test -p paid-policy --test all FILE::` runs a file's.

mod bf16;
mod files;
