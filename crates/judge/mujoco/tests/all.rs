//! The tests of `paid-mujoco` as one program: one link instead of one a file. `cargo test -p paid-mujoco --test all FILE::` runs a file's.

mod contact;
#[cfg(feature = "mujoco")]
mod g1_bodies;
#[cfg(feature = "mujoco")]
mod ground;
#[cfg(feature = "mujoco")]
mod impacts;
#[cfg(feature = "mujoco")]
mod simulator;
