//! How a command ends when it cannot do its work.

use core::fmt;
use std::process::ExitCode;

/// The exit codes, as shown in the help.
pub const EXIT_CODES: &str = "Exit codes: 0 done; 1 the program failed; 2 bad input (arguments, files, presets, full disk); \
     130 stopped by Ctrl-C or SIGTERM before the end; what was done is saved.";

/// One clear sentence for the user, whose input or file is at fault.
#[derive(Debug)]
pub struct Failure(String);

impl Failure {
    /// The user's input, or a file, is at fault: exit code 2.
    pub fn input(error: impl fmt::Display) -> Self {
        Self(error.to_string())
    }

    /// The exit code.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(2)
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// What a library refuses is bad input.
impl<E: core::error::Error> From<E> for Failure {
    fn from(error: E) -> Self {
        Self::input(error)
    }
}
