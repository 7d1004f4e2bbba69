//! The tests of `paid-world` as one program: one link instead of one a file. `cargo test -p paid-world --test all FILE::` runs a file's.

mod kick;
mod mutation;
