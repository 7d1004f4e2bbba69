//! `paid eval`.

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid eval`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Not built yet in this commit: says so.
pub fn run(_args: Args) -> Result<ExitCode, Failure> {
    Err(Failure::input("'paid eval' is not part of this build yet"))
}
