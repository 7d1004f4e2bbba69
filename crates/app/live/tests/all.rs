//! The tests of `paid-live` as one program: one link instead of one a file. `cargo test -p paid-live --test all FILE::` runs a file's.

mod browser;
mod common;
mod live;
mod match_page;
mod motions;
mod server;
mod training;
mod watch;
