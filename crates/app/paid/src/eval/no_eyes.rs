//! In the place of `paid eval shooting --eyes`, in a program that was built without it.

use std::process::ExitCode;

use paid_eval::shooting::ShootingOptions;
use paid_eval::subject::Subject;

use super::Output;
use crate::failure::Failure;
use crate::left_out;

/// The option that asks for it.
#[derive(Clone, Debug, clap::Args)]
pub struct EyesArgs {
    /// Use rendered images and a simulated LiDAR (needs a program built with --features full).
    #[arg(long)]
    eyes: bool,
}

impl EyesArgs {
    /// Refuses the option.
    ///
    /// # Errors
    /// If it was given.
    pub fn run(
        &self,
        _subject: &mut Subject,
        _kinds: &[ShootingOptions],
        _output: &Output,
    ) -> Result<Option<ExitCode>, Failure> {
        if self.eyes { Err(left_out::refusal("eval shooting --eyes")) } else { Ok(None) }
    }
}
