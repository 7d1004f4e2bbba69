//! `paid bench`: speed of the parts and of the whole.

use std::process::ExitCode;

use clap::Subcommand;

use crate::failure::Failure;
use crate::{bench_physics, bench_train};

/// Arguments of `paid bench`.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    what: What,
}

#[derive(Debug, Subcommand)]
enum What {
    /// Physics and control steps per second, compared with MuJoCo.
    Physics(bench_physics::Args),
    /// Training samples per second, end to end and by part.
    Train(bench_train::Args),
}

/// Runs a benchmark and prints its figures.
pub fn run(args: Args) -> Result<ExitCode, Failure> {
    match args.what {
        What::Physics(args) => bench_physics::run(args),
        What::Train(args) => bench_train::run(args),
    }
}
