//! How a command ends when it cannot do its work.

use core::fmt;
use std::process::ExitCode;

use paid_eval::{EvalError, Setting};
use paid_files::FileError;
use paid_motion::clean::CleanError;
use paid_plot::PlotError;
use paid_retarget::RetargetError;
use paid_train::TrainError;

/// One clear sentence for the user and the exit code that goes with it.
#[derive(Debug)]
pub struct Failure {
    message: String,
    code: u8,
    /// All of several processes have it.
    everyones: bool,
}

impl Failure {
    /// The user's input, or a file, is at fault: exit code 2.
    pub fn input(error: impl fmt::Display) -> Self {
        Self { message: error.to_string(), code: 2, everyones: false }
    }

    /// True if all of several processes have found the same out.
    pub fn is_everyones(&self) -> bool {
        self.everyones
    }

    /// A value that the libraries refuse, under the option that set it.
    fn option(flag: &str, expected: &str, found: &str) -> Self {
        Self::input(format!("{flag}: expected {expected}, found {found}"))
    }

    /// Refuses the first of `options`, names of arguments with what each is for, that is among the `given` ones and would change nothing of
    /// what was `found`.
    pub fn if_ignored<'a>(
        options: impl IntoIterator<Item = (&'a str, impl fmt::Display)>,
        given: &[String],
        found: &str,
    ) -> Result<(), Self> {
        match options.into_iter().find(|(id, _)| given.iter().any(|one| one == id)) {
            None => Ok(()),
            Some((id, expected)) => {
                let flag = id.replace('_', "-");
                Err(Self::input(format!("--{flag}: expected {expected}, found {found}")))
            }
        }
    }

    /// The exit code as a number.
    #[cfg(feature = "mpi")]
    pub fn code(&self) -> u8 {
        self.code
    }

    /// The exit code.
    pub fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code)
    }
}

/// The first of these options that was given.
pub fn first_given(options: &[(&'static str, bool)]) -> Option<&'static str> {
    options.iter().find_map(|&(option, given)| given.then_some(option))
}

/// The option that sets a value of an evaluation; the value's own name where no option does.
fn flag_of(setting: Setting) -> &'static str {
    match setting {
        Setting::Knowledge => "--knowledge",
        Setting::Trials => "--trials",
        Setting::Limit => "--limit",
        Setting::StartRadius => "--start-radius",
        Setting::Scatter => "--scatter",
        Setting::Rolling => "--speed",
        Setting::Scene => "--scene",
        Setting::Recording => "--rerun",
        Setting::Seconds => "--seconds",
        Setting::Named(name) => name,
    }
}

/// The option that sets a value of a retargeting.
fn retarget_flag_of(setting: paid_retarget::Setting) -> &'static str {
    use paid_retarget::Setting;
    match setting {
        Setting::Part => "--from, --to",
        Setting::ClipRate => "--rate",
        Setting::Height => "--height",
        Setting::Begin => "--from",
        Setting::End => "--to",
        Setting::TimeScale => "--slow",
        Setting::SpeedShare => "--speed-limit",
        Setting::Unit => "--unit",
        Setting::FileRate => "--fps",
    }
}

impl From<paid_terminal::Failure> for Failure {
    fn from(failure: paid_terminal::Failure) -> Self {
        Self::input(failure)
    }
}

impl From<EvalError> for Failure {
    fn from(error: EvalError) -> Self {
        match &error {
            EvalError::Plot(PlotError::Animation { expected, found }) => {
                Self::option("--record", expected, found)
            }
            EvalError::Option { option, expected, found } => Self::option(flag_of(*option), expected, found),
            EvalError::NoBall { .. } => {
                Self::input(format!("{error}; score in another with --task paper_stage2"))
            }
            _ => Self::input(error),
        }
    }
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Self {
        match &error {
            PlotError::Animation { expected, found } => Self::option("--record", expected, found),
            PlotError::File(_) => Self::input(error),
        }
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        Self::input(error)
    }
}

impl From<TrainError> for Failure {
    fn from(error: TrainError) -> Self {
        Self { everyones: matches!(error, TrainError::Ranks(_)), ..Self::input(error) }
    }
}

impl From<RetargetError> for Failure {
    fn from(error: RetargetError) -> Self {
        match &error {
            RetargetError::Option { option, expected, found } => {
                Self::option(retarget_flag_of(*option), expected, found)
            }
            RetargetError::Skeleton { .. } => Self::input(format!("{error}; name one with --skeleton")),
            _ => Self::input(error),
        }
    }
}

impl From<CleanError> for Failure {
    fn from(error: CleanError) -> Self {
        match &error {
            CleanError::Option { option, expected, found } => {
                Self::input(format!("--{option}: expected {expected}, found {found}"))
            }
            _ => Self::input(error),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_that_a_library_refuses_is_told_with_its_option() {
        let error = EvalError::Option {
            option: Setting::Rolling,
            expected: "a range".into(),
            found: "3 to 1".into(),
        };
        assert_eq!(error.to_string(), "rolling: expected a range, found 3 to 1");
        assert_eq!(Failure::from(error).to_string(), "--speed: expected a range, found 3 to 1");
        let error =
            EvalError::Option { option: Setting::Named("grid"), expected: "a".into(), found: "b".into() };
        assert_eq!(Failure::from(error).to_string(), "grid: expected a, found b");
    }
}
