//! `paid train`.

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid train`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Not built yet in this commit: says so.
pub fn run(_args: Args) -> Result<ExitCode, Failure> {
    Err(Failure::input("'paid train' is not part of this build yet"))
}
