//! Input that is no kick of a robot on its feet, reported before anything is computed.

use paid_robot::{RobotModel, RobotSpec};

use super::{CleanError, CleanOptions};
use crate::Clip;
use crate::implausible::Implausible;

/// Shortest and longest motion `[s]`.
const LENGTH: std::ops::RangeInclusive<f64> = 0.5..=120.0;

pub(super) fn options(options: &CleanOptions) -> Result<(), CleanError> {
    let checks = [
        ("clean-rate", "20 to 200 Hz", options.fps, 20.0..=200.0),
        ("stretch", "1 to 4", options.slow.unwrap_or(1.0), 1.0..=4.0),
        ("torque", "0.2 to 5", options.torque_share, 0.2..=5.0),
        ("lead", "0.5 to 60 s", options.lead_s, 0.5..=60.0),
        ("facing", "0 to 90 degrees", options.facing.to_degrees(), 0.0..=90.0),
    ];
    match checks.into_iter().find(|(.., value, range)| !range.contains(value)) {
        Some((option, expected, found, _)) => Err(CleanError::Option { option, expected, found }),
        None => Ok(()),
    }
}

pub(super) fn motion(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Result<(), CleanError> {
    let name = || clip.name.clone();
    let bad = |t: &usize| {
        let numbers = clip.body_pos(*t)[0].into_iter().chain(clip.body_quat(*t)[0]);
        !numbers.chain(clip.joint_pos(*t).iter().copied()).all(f64::is_finite)
    };
    if let Some(frame) = (0..clip.frames).find(bad) {
        return Err(CleanError::Number { name: name(), frame });
    }
    let seconds = clip.duration_s();
    if !LENGTH.contains(&seconds) || clip.frames < 10 {
        return Err(CleanError::Length { name: name(), frames: clip.frames, seconds });
    }
    match Implausible::of(clip, model, spec) {
        Some(what) => Err(CleanError::Implausible { name: name(), what: what.to_string() }),
        None => Ok(()),
    }
}
