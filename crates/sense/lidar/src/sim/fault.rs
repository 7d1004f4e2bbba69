//! What can go wrong with the sensor.

use core::str::FromStr;

use nalgebra::Vector3;

use crate::error::LidarError;
use crate::sim::sensor::Frame;

/// Something that goes wrong with the sensor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// No returns for this long `[s]`.
    Covered(f64),
    /// The sensor is carried by this vector `[m]` and the IMU does not measure it.
    Kidnapped(Vector3<f64>),
    /// Data come this much later than before `[s]`, for this long `[s]`.
    Late(f64, f64),
    /// No IMU samples for this long `[s]`.
    ImuGap(f64),
    /// Time stamps fall back by this much `[s]`.
    Backwards(f64),
    /// Nothing comes for this long `[s]`.
    Silent(f64),
}

/// Which fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// See [`Fault::Covered`].
    Covered,
    /// See [`Fault::Kidnapped`].
    Kidnapped,
    /// See [`Fault::Late`].
    Late,
    /// See [`Fault::ImuGap`].
    Gap,
    /// See [`Fault::Backwards`].
    Backwards,
    /// See [`Fault::Silent`].
    Silent,
}

impl FromStr for FaultKind {
    type Err = LidarError;

    fn from_str(name: &str) -> Result<Self, LidarError> {
        Ok(match name {
            "covered" => Self::Covered,
            "kidnapped" => Self::Kidnapped,
            "late" => Self::Late,
            "gap" => Self::Gap,
            "backwards" => Self::Backwards,
            "silent" => Self::Silent,
            found => {
                return Err(LidarError::Name {
                    name: "fault",
                    expected: "covered, kidnapped, late, gap, backwards, silent",
                    found: found.to_owned(),
                });
            }
        })
    }
}

/// What a fault does besides changing a frame's data.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Effect {
    /// Delay on the way `[s]`.
    pub delay_s: f64,
    /// Nothing comes at all.
    pub silent: bool,
}

impl Fault {
    /// The fault of that kind with the protocol's values.
    #[must_use]
    pub fn usual(kind: FaultKind) -> Self {
        match kind {
            FaultKind::Covered => Self::Covered(1.0),
            FaultKind::Kidnapped => Self::Kidnapped(Vector3::new(1.8, 1.1, 0.0)),
            FaultKind::Late => Self::Late(0.1, 1.0),
            FaultKind::Gap => Self::ImuGap(0.08),
            FaultKind::Backwards => Self::Backwards(1.5),
            FaultKind::Silent => Self::Silent(1.0),
        }
    }

    /// Changes a frame that ends `since_s` after the fault's begin at `at_s` `[s]`.
    pub(crate) fn apply(&self, frame: &mut Frame, at_s: f64, since_s: f64) -> Effect {
        let mut effect = Effect::default();
        match *self {
            Self::Covered(span_s) if since_s < span_s => {
                frame.scan.points.iter_mut().for_each(|p| p.position = Vector3::zeros());
            }
            Self::Late(by_s, span_s) if since_s < span_s => effect.delay_s = by_s,
            Self::ImuGap(span_s) => frame.imu.retain(|s| s.time_s <= at_s || s.time_s > at_s + span_s),
            Self::Backwards(by_s) => {
                frame.imu.iter_mut().for_each(|s| s.time_s -= by_s);
                frame.scan.start_s -= by_s;
                frame.scan.end_s -= by_s;
            }
            Self::Silent(span_s) if since_s < span_s => {
                frame.imu.clear();
                effect.silent = true;
            }
            Self::Covered(_) | Self::Late(..) | Self::Kidnapped(_) | Self::Silent(_) => {}
        }
        effect
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_fault_is_named_with_those_there_are() {
        assert_eq!("late".parse::<FaultKind>().ok(), Some(FaultKind::Late));
        let error = "tired".parse::<FaultKind>().expect_err("sensors do not tire").to_string();
        assert!(error.starts_with("fault: expected one of covered, kidnapped"), "{error}");
    }
}
