//! `paid bench train`.

use std::process::ExitCode;

use crate::failure::Failure;

/// Arguments of `paid bench train`.
#[derive(Debug, clap::Args)]
pub struct Args {}

/// Not built yet in this commit: says so.
pub fn run(_args: Args) -> Result<ExitCode, Failure> {
    Err(Failure::input("'paid bench train' is not part of this build yet"))
}
