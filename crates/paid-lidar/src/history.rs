//! Poses of the last second, at the rate of the IMU.

use std::collections::VecDeque;

use nalgebra::Isometry3;

use crate::undistort::Motion;

/// Scans that are kept: one second of a Mid-360.
const SCANS: usize = 10;

#[derive(Clone, Debug)]
struct Stretch {
    start_s: f64,
    end_s: f64,
    motion: Motion,
    correction: Isometry3<f64>,
}

/// Predicted motion over the last scans, each moved by its scan's correction.
#[derive(Clone, Debug, Default)]
pub struct History {
    stretches: VecDeque<Stretch>,
}

impl History {
    /// Adds the motion of a scan; `correction` leads from the predicted to the corrected pose at its end.
    pub fn push(&mut self, motion: &Motion, start_s: f64, end_s: f64, correction: &Isometry3<f64>) {
        if self.stretches.len() >= SCANS {
            self.stretches.pop_front();
        }
        self.stretches.push_back(Stretch { start_s, end_s, motion: motion.clone(), correction: *correction });
    }

    /// Pose of the IMU in the odometry frame at `time_s`.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> Option<Isometry3<f64>> {
        let stretch = self.stretches.iter().rev().find(|s| s.start_s <= time_s && time_s <= s.end_s)?;
        stretch.motion.odometry_from_imu(time_s).map(|pose| stretch.correction * pose)
    }
}
