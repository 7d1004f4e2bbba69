//! Poses of the last second, at the rate of the IMU.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};
use paid_lanes::{Quat, Vec3};
use paid_track::{PoseBuffer, StampedPose};

use crate::undistort::Motion;

/// Poses are kept for this long `[s]`: images are at most some 0.2 s old.
const KEPT_S: f64 = 1.0;
/// Poses come with the samples of the IMU, 5 ms apart; a longer silence `[s]` is a hole: a scan that did not fit, a lost sensor.
const HOLE_S: f64 = 0.06;

/// Predicted motion over the last scans, each moved by its scan's correction.
#[derive(Clone, Debug)]
pub struct History {
    poses: PoseBuffer,
}

impl Default for History {
    fn default() -> Self {
        Self { poses: PoseBuffer::new(KEPT_S, 0.0).with_longest_gap(HOLE_S) }
    }
}

impl History {
    /// Adds the motion of a scan that ended at `end_s`; `correction` leads from the predicted to the corrected pose there.
    pub fn push(&mut self, motion: &Motion, end_s: f64, correction: &Isometry3<f64>) {
        let end = motion.odometry_from_imu(end_s).map(|pose| (end_s, pose));
        for (time_s, pose) in motion.poses().filter(|(time_s, _)| *time_s < end_s).chain(end) {
            self.poses.push(stamped(time_s, &(correction * pose)));
        }
    }

    /// Pose of the IMU in the odometry frame at `time_s`.
    #[must_use]
    pub fn pose_at(&self, time_s: f64) -> Option<Isometry3<f64>> {
        self.poses.stamped_at(time_s).ok().map(|pose| isometry(&pose))
    }
}

/// A pose as the buffer takes it.
#[must_use]
pub fn stamped(time_s: f64, pose: &Isometry3<f64>) -> StampedPose {
    let (q, p) = (pose.rotation.quaternion(), pose.translation.vector);
    StampedPose { time_s, quat: Quat([q.w, q.i, q.j, q.k]), pos: Vec3([p.x, p.y, p.z]) }
}

/// The pose of the buffer as it is used here.
#[must_use]
pub fn isometry(pose: &StampedPose) -> Isometry3<f64> {
    let ([w, x, y, z], [px, py, pz]) = (pose.quat.0, pose.pos.0);
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(Vector3::new(px, py, pz)), rotation)
}
