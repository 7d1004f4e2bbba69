//! What can be wrong with the input.

/// Settings or clips that cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AmpError {
    /// A value of the configuration.
    #[error("amp.{key}: expected {expected}, found {found}")]
    Config {
        /// Key below `amp`.
        key: &'static str,
        /// Range.
        expected: &'static str,
        /// Value.
        found: String,
    },
    /// Frames of the clips.
    #[error("frames of clip {clip}: expected {expected}, found {found}")]
    Clip {
        /// Number of the clip.
        clip: usize,
        /// What was wanted.
        expected: String,
        /// What is there.
        found: String,
    },
}
