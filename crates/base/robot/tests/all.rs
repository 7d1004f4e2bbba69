//! The tests of `paid-robot` as one program: one link instead of one a file. `cargo test -p paid-robot --test all FILE::` runs a file's.

mod g1;
mod kinematics;
mod mjcf;
mod motions;
mod spec;
mod variant;
