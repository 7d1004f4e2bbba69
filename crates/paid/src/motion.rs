//! `paid motion`.

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid motion`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Not built yet in this commit: says so.
pub fn run(_args: Args) -> Result<ExitCode, Failure> {
    Err(Failure::input("'paid motion' is not part of this build yet"))
}
