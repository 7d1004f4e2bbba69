//! The commands `run`, `check` and `replay`, for the program `paid-robot` and for `paid robot`, which adds a page in the browser and
//! charts.

// The help texts are doc comments. Units stand in brackets there and are no links.
#![allow(rustdoc::broken_intra_doc_links)]

// `print` and `println` that end the program with an error.
#[macro_use]
extern crate paid_terminal;

mod args;
mod eyes;
mod network;
mod replay;
mod screen;

pub use args::{
    NetworkArgs, PlayerArgs, at_least_one, domain, duration, print_event, print_latency, print_usage,
    read_limits,
};
pub use network::{CheckArgs, RunArgs, Teller, check, run};
pub use replay::{ReplayArgs, replay};
