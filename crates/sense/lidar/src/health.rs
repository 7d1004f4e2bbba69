//! How far the odometry can be trusted, as text.

use core::fmt;

use nalgebra::Vector3;

/// State of the odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Health {
    /// Waits for the sensor to stand still; why it does not start, if there is a reason.
    Initializing(Option<NotStill>),
    /// The pose follows from scans in all directions.
    Tracking,
    /// The pose follows from scans but along one direction, where it rests on the IMU alone.
    Degenerate {
        /// Unit vector in the odometry frame.
        direction: Vector3<f64>,
    },
    /// The pose does not follow from scans. It is the IMU's, and soon worthless.
    Lost {
        /// Why.
        reason: LostReason,
        /// It has lasted too long to come back by itself: only a restart, with a new odometry frame, helps.
        refused: bool,
    },
}

impl Health {
    /// Whether the pose may be used in all directions.
    #[must_use]
    pub fn is_tracking(&self) -> bool {
        *self == Self::Tracking
    }

    /// Whether the odometry is lost.
    #[must_use]
    pub fn is_lost(&self) -> bool {
        matches!(self, Self::Lost { .. })
    }
}

/// Why the sensor does not count as standing still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NotStill {
    /// It turns: mean length or deviation of angular velocity `[rad/s]`.
    Turns {
        /// Found.
        found: f64,
        /// Most that counts as still.
        most: f64,
    },
    /// It shakes: deviation of acceleration `[m/s^2]`.
    Shakes {
        /// Found.
        found: f64,
        /// Most that counts as still.
        most: f64,
    },
    /// The mean acceleration is not gravity `[m/s^2]`.
    NotGravity {
        /// Found.
        found: f64,
    },
}

impl fmt::Display for NotStill {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Turns { found, most } => {
                write!(
                    f,
                    "the sensor turns: expected at most {most:.2} rad/s, found {found:.2}; stand still to start"
                )
            }
            Self::Shakes { found, most } => {
                write!(
                    f,
                    "the sensor shakes: expected at most {most:.1} m/s^2, found {found:.1}; stand still to start"
                )
            }
            Self::NotGravity { found } => {
                write!(
                    f,
                    "acceleration at rest: expected 9.81 m/s^2 within 10%, found {found:.2} (values in g?)"
                )
            }
        }
    }
}

/// Why the odometry is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LostReason {
    /// The scan is nearly empty: the sensor is covered.
    TooFewPoints {
        /// Points of the thinned scan.
        found: usize,
        /// Points needed.
        needed: usize,
    },
    /// The scan does not fit the map at the predicted pose: kidnapped, or the scene has changed.
    Mismatch {
        /// Share of points that fit.
        share: f64,
        /// Usual share.
        usual: f64,
    },
    /// The scan fits the map, but far from the predicted pose.
    Jump {
        /// Distance from the prediction `[m]`.
        distance_m: f64,
        /// Angle from the prediction `[rad]`.
        angle_rad: f64,
    },
    /// Data come later than they used to.
    Late {
        /// By how much `[s]`.
        by_s: f64,
    },
    /// A time stamp is before an earlier one.
    TimeBackwards {
        /// By how much `[s]`.
        by_s: f64,
    },
    /// IMU samples are missing.
    ImuGap {
        /// Length of the gap `[s]`.
        gap_s: f64,
    },
    /// No scans come.
    NoScan {
        /// For how long `[s]`.
        silent_s: f64,
    },
    /// The filter's numbers are not finite.
    Diverged,
}

impl fmt::Display for LostReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::TooFewPoints { found, needed } => {
                write!(f, "covered? expected at least {needed} points, found {found}")
            }
            Self::Mismatch { share, usual } => {
                write!(
                    f,
                    "kidnapped? {:.0}% of the scan fit the map, usually {:.0}%",
                    100.0 * share,
                    100.0 * usual
                )
            }
            Self::Jump { distance_m, angle_rad } => write!(
                f,
                "the scan fits {distance_m:.2} m and {:.1} deg from the prediction",
                angle_rad.to_degrees()
            ),
            Self::Late { by_s } => write!(f, "data late by {:.0} ms", 1e3 * by_s),
            Self::TimeBackwards { by_s } => write!(f, "a time stamp {by_s:.3} s before an earlier one"),
            Self::ImuGap { gap_s } => write!(f, "no IMU for {gap_s:.3} s"),
            Self::NoScan { silent_s } => write!(f, "no scan for {silent_s:.2} s"),
            Self::Diverged => f.write_str("the filter's numbers are not finite"),
        }
    }
}

impl fmt::Display for Health {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Initializing(None) => f.write_str("initializing"),
            Self::Initializing(Some(why)) => write!(f, "initializing: {why}"),
            Self::Tracking => f.write_str("tracking"),
            Self::Degenerate { direction: d } => {
                write!(f, "degenerate: motion along ({:.2}, {:.2}, {:.2}) is not seen", d.x, d.y, d.z)
            }
            Self::Lost { reason, refused: false } => write!(f, "lost: {reason}"),
            Self::Lost { reason, refused: true } => write!(f, "lost for good, restart: {reason}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_state_says_what_is_the_matter() {
        let lost = |reason| Health::Lost { reason, refused: false };
        assert_eq!(
            lost(LostReason::TooFewPoints { found: 3, needed: 50 }).to_string(),
            "lost: covered? expected at least 50 points, found 3"
        );
        assert_eq!(lost(LostReason::Late { by_s: 0.1 }).to_string(), "lost: data late by 100 ms");
        let degenerate = Health::Degenerate { direction: Vector3::x() };
        assert_eq!(degenerate.to_string(), "degenerate: motion along (1.00, 0.00, 0.00) is not seen");
        assert!(!degenerate.is_tracking() && !degenerate.is_lost());
    }
}
