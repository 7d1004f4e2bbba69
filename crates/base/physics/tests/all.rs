//! The tests of `paid-physics` as one program: one link instead of one a file. `cargo test -p paid-physics --test all FILE::` runs a file's.

mod ball;
mod common;
mod falls;
mod flight;
mod kick;
mod mujoco;
mod robust;
mod soft;
mod standing;
