//! Commands that a program built without the cargo feature `full` does not have.

use std::process::ExitCode;

use crate::failure::Failure;

/// Whatever was given to the command.
#[derive(Debug, clap::Args)]
#[command(disable_help_flag = true)]
pub struct Args {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    rest: Vec<String>,
}

/// How to get a command.
pub fn refusal(command: &str) -> Failure {
    Failure::input(format!(
        "'paid {command}' is not in this program; build it with 'cargo build --release --features full'"
    ))
}

impl Args {
    /// Refuses the command.
    ///
    /// # Errors
    /// Always.
    pub fn run(&self, command: &str) -> Result<ExitCode, Failure> {
        let given = self.rest.first().filter(|word| !word.starts_with('-'));
        Err(refusal(&given.map_or_else(|| command.to_owned(), |word| format!("{command} {word}"))))
    }
}
