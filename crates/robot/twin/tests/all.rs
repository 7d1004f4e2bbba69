//! The tests of `paid-twin` as one program: one link instead of one a file. `cargo test -p paid-twin --test all FILE::` runs a file's.

mod common;
mod eyes_lockstep;
#[cfg(feature = "dds")]
mod eyes_wire;
mod lockstep;
mod observation;
#[cfg(feature = "dds")]
mod peers;
mod standing;
mod targets;
#[cfg(feature = "dds")]
mod vendor_sim;
#[cfg(feature = "dds")]
mod wire;
