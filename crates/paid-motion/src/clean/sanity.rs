//! Input that is no kick of a robot on its feet, told before anything is computed.

use paid_lanes::{Quat, Vec3};
use paid_robot::RobotSpec;

use super::{CleanError, CleanOptions};
use crate::Clip;

/// Shortest and longest motion `[s]`.
const LENGTH: std::ops::RangeInclusive<f64> = 0.5..=120.0;

pub(super) fn options(options: &CleanOptions) -> Result<(), CleanError> {
    let checks = [
        ("clean-rate", "20 to 200 Hz", options.fps, 20.0..=200.0),
        ("stretch", "1 to 4", options.slow.unwrap_or(1.0), 1.0..=4.0),
        ("torque", "0.2 to 5", options.torque_share, 0.2..=5.0),
    ];
    match checks.into_iter().find(|(.., value, range)| !range.contains(value)) {
        Some((option, expected, found, _)) => Err(CleanError::Option { option, expected, found }),
        None => Ok(()),
    }
}

pub(super) fn motion(clip: &Clip, spec: &RobotSpec) -> Result<(), CleanError> {
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
    let mut heights: Vec<f64> = (0..clip.frames).map(|t| clip.body_pos(t)[0][2]).collect();
    heights.sort_by(f64::total_cmp);
    let (found, expected) = (heights[heights.len() / 2], spec.nominal_height_m);
    let share = found / expected;
    let lies = |t: &usize| Quat(clip.body_quat(*t)[0]).rotate(Vec3([0.0, 0.0, 1.0])).z() < 0.5;
    let lying = (0..clip.frames).filter(lies).count() as f64 / clip.frames as f64;
    let hint = match share {
        s if (30.0..300.0).contains(&s) => ": these look like centimeters",
        s if (300.0..3000.0).contains(&s) => ": these look like millimeters",
        s if s > 2.0 => ": it floats, or the unit of length is another",
        s if (0.003..0.03).contains(&s) => ": meters divided by 100?",
        _ => "",
    };
    if !hint.is_empty() {
        return Err(CleanError::Height { name: name(), expected, found, hint });
    }
    if lying > 0.5 {
        return Err(CleanError::Lies { name: name(), share: 100.0 * lying });
    }
    if share < 0.4 {
        return Err(CleanError::Height { name: name(), expected, found, hint: ": it does not stand" });
    }
    Ok(())
}
