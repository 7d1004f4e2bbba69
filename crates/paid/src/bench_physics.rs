//! `paid bench physics`.

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid bench physics`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Not built yet in this commit: says so.
pub fn run(_args: Args) -> Result<ExitCode, Failure> {
    Err(Failure::input("'paid bench physics' is not part of this build yet"))
}
