//! What can be wrong with an image.

use std::fmt;

/// What is wrong with an image. A ball is looked for only where [`PictureFault::is_blind`] is false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureFault {
    /// Nothing but darkness.
    Black {
        /// The mean of all bytes, 0 to 255.
        mean: f64,
    },
    /// Everything of one color: a covered lens, a driver that fills in.
    Uniform {
        /// The standard deviation of all bytes.
        deviation: f64,
    },
    /// Byte for byte the image before: sensors have noise.
    Frozen {
        /// How many in a row.
        pictures: u32,
    },
    /// A part of the rows is the image before or of one color: it was cut off on its way.
    Torn {
        /// How many rows of its end.
        rows: usize,
    },
    /// Color or depth is not of the size in the camera's intrinsics.
    Size {
        /// Width and height that were expected `[px]`.
        expected: [usize; 2],
        /// And found.
        found: [usize; 2],
    },
    /// The intrinsics are not those that the robot was set up with.
    Intrinsics {
        /// Focal length across that was expected `[px]`.
        expected: f64,
        /// And found.
        found: f64,
    },
    /// The middle of the image is not where the setup has it.
    Center {
        /// Place of the optical axis that was expected `[px]`.
        expected: [f64; 2],
        /// And found.
        found: [f64; 2],
    },
    /// It was taken before or with the one before.
    TimeBackwards {
        /// By this much `[s]`.
        by_s: f64,
    },
    /// It is too old to be used, or from the future.
    Time {
        /// Its age at its arrival `[s]`.
        age_s: f64,
    },
    /// The depth image knows nothing. The color image is used.
    NoDepth,
    /// The depth image is byte for byte the one before. The color image is used.
    DepthFrozen {
        /// How many in a row.
        pictures: u32,
    },
    /// The last rows of the depth image are those of the one before, or of one depth. The color image is used.
    DepthTorn {
        /// How many rows of its end.
        rows: usize,
    },
}

impl PictureFault {
    /// Whether no ball may be looked for in the image.
    pub fn is_blind(&self) -> bool {
        !matches!(self, Self::NoDepth | Self::DepthFrozen { .. } | Self::DepthTorn { .. })
    }
}

impl fmt::Display for PictureFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Black { mean } => write!(f, "image black: mean {mean:.1} of 255, expected 6 or more"),
            Self::Uniform { deviation } => {
                write!(f, "image of one color: deviation {deviation:.1} of 255, expected 2 or more")
            }
            Self::Frozen { pictures } => write!(f, "image frozen: {pictures} equal ones in a row"),
            Self::Torn { rows } => write!(f, "image torn: its last {rows} rows are from another image"),
            Self::Size { expected: [w, h], found: [x, y] } => {
                write!(f, "image of {x} x {y} pixels, expected {w} x {h} as in the intrinsics")
            }
            Self::Intrinsics { expected, found } => {
                write!(f, "intrinsics: focal length {found:.1} px, expected {expected:.1} px within 2%")
            }
            Self::Center { expected: [x, y], found: [u, v] } => write!(
                f,
                "intrinsics: optical axis at ({u:.1}, {v:.1}) px, expected ({x:.1}, {y:.1}) px within 1% of the width"
            ),
            Self::TimeBackwards { by_s } => {
                write!(f, "image taken {by_s:.3} s before the one before it, expected a later time")
            }
            Self::Time { age_s } => write!(f, "image {age_s:.3} s old, expected 0 to 0.5 s"),
            Self::NoDepth => write!(f, "depth unknown in the whole image"),
            Self::DepthFrozen { pictures } => write!(f, "depth frozen: {pictures} equal ones in a row"),
            Self::DepthTorn { rows } => write!(f, "depth torn: its last {rows} rows are from another image"),
        }
    }
}
