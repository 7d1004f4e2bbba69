//! What a caller can do wrong.

use thiserror::Error;

/// A setting, a file or a socket that cannot be used.
#[derive(Debug, Error)]
pub enum LidarError {
    /// A setting is outside what makes sense.
    #[error("{name}: expected {expected}, found {found}")]
    Setting {
        /// Name of the setting.
        name: &'static str,
        /// What it has to be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A list of timed poses cannot be followed.
    #[error("timed poses, number {index}: expected {expected}, found {found}")]
    Pose {
        /// Which pose, from 0.
        index: usize,
        /// What it has to be.
        expected: &'static str,
        /// What it is.
        found: String,
    },
    /// A name that is not known.
    #[error("{name}: expected one of {expected}, found '{found}'")]
    Name {
        /// What the name stands for.
        name: &'static str,
        /// The names there are.
        expected: &'static str,
        /// The name given.
        found: String,
    },
    /// The network.
    #[error("{address}: {error}")]
    Socket {
        /// Local address.
        address: String,
        /// The system's error.
        error: std::io::Error,
    },
    /// A simulated run in which the odometry never began to track.
    #[error("{scene}: no tracked scan in {seconds_s} s; the last state was: {last}")]
    NeverTracked {
        /// Scene.
        scene: &'static str,
        /// Length of the run `[s]`.
        seconds_s: f64,
        /// Last state.
        last: String,
    },
}
