//! The tests of `paid` as one program: one link instead of one a file. `cargo test -p paid --test all FILE::` runs a file's.

mod bad_input;
mod book;
mod commands;
mod common;
mod compare;
mod eval;
mod eval_input;
mod explain;
mod foreign;
#[path = "../../../skill/retarget/tests/common/mod.rs"]
mod human;
mod live;
mod look;
mod motion;
#[cfg(feature = "mpi")]
mod mpi;
mod perceive;
mod policies;
mod robot;
mod robot_program;
mod sysid;
#[cfg(feature = "train-detector")]
mod train_detector;
