//! Why a motion cannot be cleaned.

use paid_robot::SpecError;
use thiserror::Error;

/// Why a motion cannot be cleaned.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CleanError {
    /// A length that is no kick's.
    #[error(
        "{name}: expected a motion of 0.5 to 120 s, found {frames} frames in {seconds:.2} s; cut the kick out with `paid motion cut`"
    )]
    Length {
        /// The clip.
        name: String,
        /// Its frames.
        frames: usize,
        /// Its length `[s]`.
        seconds: f64,
    },
    /// A number that is none.
    #[error("{name}: expected finite numbers, found another in frame {frame}")]
    Number {
        /// The clip.
        name: String,
        /// The first bad frame.
        frame: usize,
    },
    /// No robot on its feet, in meters, with z up.
    #[error("{name}: {what}")]
    Implausible {
        /// The clip.
        name: String,
        /// What was expected and what was found.
        what: String,
    },
    /// No feet to stand on.
    #[error("{name}: the robot lacks the feet that its TOML names")]
    Feet {
        /// The clip.
        name: String,
    },
    /// Feet that do not stand.
    #[error(
        "{name}: expected feet that stand, found both in the air in {flight} of {frames} frames: no kick from the ground"
    )]
    Air {
        /// The clip.
        name: String,
        /// Frames in the air.
        flight: usize,
        /// All frames.
        frames: usize,
    },
    /// An option out of range.
    #[error("{option}: expected {expected}, found {found}")]
    Option {
        /// Which.
        option: &'static str,
        /// Its range.
        expected: &'static str,
        /// What was given.
        found: f64,
    },
    /// The robot's TOML and MJCF do not fit together.
    #[error(transparent)]
    Robot(#[from] SpecError),
}

impl CleanError {
    /// The same error of a clip called `by`: a command names the file that it read.
    pub fn named(mut self, by: impl Into<String>) -> Self {
        match &mut self {
            Self::Length { name, .. }
            | Self::Number { name, .. }
            | Self::Implausible { name, .. }
            | Self::Feet { name }
            | Self::Air { name, .. } => *name = by.into(),
            Self::Option { .. } | Self::Robot(_) => {}
        }
        self
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_about_a_clip_can_name_its_file() {
        let error = CleanError::Air { name: "kick".to_owned(), flight: 9, frames: 10 }.named("two/kick.npz");
        assert!(error.to_string().starts_with("two/kick.npz: expected feet that stand"), "{error}");
        let option = CleanError::Option { option: "lead", expected: "0.5 to 60 s", found: 99.0 };
        assert_eq!(option.clone().named("kick.npz"), option);
    }
}
