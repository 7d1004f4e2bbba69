//! Rigid poses and their history: one buffer to look up where a body was at a time.

use std::collections::VecDeque;

use crate::CameraPreset;
use paid_lanes::{Mat3, Quat, Vec3};

/// Where a frame is in another one: `outer = rot inner + pos`.
#[derive(Clone, Copy, Debug)]
pub struct Pose {
    /// Rotation, outer from inner.
    pub rot: Mat3<f64>,
    /// Origin of the inner frame in the outer one `[m]`.
    pub pos: Vec3<f64>,
}

impl Pose {
    /// The same frame.
    pub fn identity() -> Self {
        Self { rot: Mat3::identity(), pos: Vec3::zero() }
    }

    /// A point of the inner frame in the outer one `[m]`.
    #[inline]
    pub fn point(&self, inner: [f64; 3]) -> [f64; 3] {
        (self.rot.mul_vec(Vec3(inner)) + self.pos).0
    }

    /// A point of the outer frame in the inner one `[m]`.
    #[inline]
    pub fn inverse_point(&self, outer: [f64; 3]) -> [f64; 3] {
        self.rot.tr_mul_vec(Vec3(outer) - self.pos).0
    }

    /// `self` after `inner`: where a frame given in the inner one is in the outer one.
    pub fn compose(&self, inner: &Self) -> Self {
        Self { rot: self.rot.mul_mat(&inner.rot), pos: self.rot.mul_vec(inner.pos) + self.pos }
    }

    /// The other way round.
    pub fn inverse(&self) -> Self {
        let rot = self.rot.transpose();
        Self { rot, pos: -rot.mul_vec(self.pos) }
    }

    /// The optical frame of a camera in the frame of the body that carries it.
    pub fn of_camera(camera: &CameraPreset) -> Self {
        let (sin, cos) = camera.down_deg.to_radians().sin_cos();
        // Columns: right, down and ahead of the image in the body's axes.
        let rot = Mat3([[0.0, -sin, cos], [-1.0, 0.0, 0.0], [0.0, -cos, -sin]]);
        Self { rot, pos: Vec3(camera.mount_m) }
    }

    /// The D435i of the G1 in the frame of its torso, from the robot's description.
    pub fn g1_camera() -> Self {
        let preset = CameraPreset {
            mount_m: [0.057_623_5, 0.017_53, 0.429_87],
            down_deg: 0.830_78_f64.to_degrees(),
            ..CameraPreset::color()
        };
        Self::of_camera(&preset)
    }
}

/// A pose with the time at which it held `[s]`.
#[derive(Clone, Copy, Debug)]
pub struct StampedPose {
    /// Time `[s]`.
    pub time_s: f64,
    /// Orientation, a unit quaternion w, x, y, z.
    pub quat: Quat<f64>,
    /// Place `[m]`.
    pub pos: Vec3<f64>,
}

impl StampedPose {
    /// Without the time.
    pub fn pose(&self) -> Pose {
        Pose { rot: self.quat.to_mat(), pos: self.pos }
    }
}

/// Why a pose is not known at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PoseGap {
    /// Older than everything that is kept.
    TooOld,
    /// Newer than the last pose by more than the horizon.
    TooNew,
    /// Between two poses that are too far apart in time.
    Hole,
    /// No pose has arrived yet.
    Empty,
}

/// The last poses of a body, to ask where it was when an image was taken.
///
/// Between two poses the place is interpolated linearly and the orientation along the shorter great circle. Up to `ahead_s` after the last
/// one, the motion of the last two continues.
#[derive(Clone, Debug)]
pub struct PoseBuffer {
    poses: VecDeque<StampedPose>,
    keep_s: f64,
    ahead_s: f64,
    longest_gap_s: f64,
}

impl Default for PoseBuffer {
    /// One second of history: images are at most some 0.2 s old. 0.05 s ahead: odometry at 10 Hz or more with its own prediction.
    fn default() -> Self {
        Self::new(1.0, 0.05)
    }
}

impl PoseBuffer {
    /// A buffer of `keep_s` seconds that continues for `ahead_s` seconds after the last pose.
    pub fn new(keep_s: f64, ahead_s: f64) -> Self {
        Self { poses: VecDeque::new(), keep_s, ahead_s, longest_gap_s: f64::INFINITY }
    }

    /// Poses that are farther apart than this `[s]` say nothing of the time between them.
    #[must_use]
    pub fn with_longest_gap(mut self, longest_gap_s: f64) -> Self {
        self.longest_gap_s = longest_gap_s;
        self
    }

    /// Has room for this many poses from the beginning: a thread that keeps no more of them allocates nothing.
    #[must_use]
    pub fn with_room(mut self, poses: usize) -> Self {
        self.poses.reserve(poses);
        self
    }

    /// The newest pose.
    pub fn last(&self) -> Option<&StampedPose> {
        self.poses.back()
    }

    /// Adds a pose. Returns whether it was taken: one that is not finite is refused, and so is one that is not newer than the last. Time
    /// that runs back by more than the history begins a new one: the clock was set.
    pub fn push(&mut self, pose: StampedPose) -> bool {
        let numbers = pose.quat.0.iter().chain(&pose.pos.0).chain([&pose.time_s]);
        if !numbers.clone().all(|v| v.is_finite()) {
            return false;
        }
        if let Some(last) = self.poses.back() {
            if pose.time_s < last.time_s - self.keep_s {
                self.poses.clear();
            } else if pose.time_s <= last.time_s {
                return false;
            }
        }
        self.poses.push_back(pose);
        while self.poses.front().is_some_and(|first| first.time_s < pose.time_s - self.keep_s) {
            self.poses.pop_front();
        }
        true
    }

    /// The pose at a time `[s]`.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn at(&self, time_s: f64) -> Result<Pose, PoseGap> {
        self.stamped_at(time_s).map(|pose| pose.pose())
    }

    /// As [`Self::at`], with the orientation as a quaternion.
    ///
    /// # Errors
    /// Why it is not known.
    pub fn stamped_at(&self, time_s: f64) -> Result<StampedPose, PoseGap> {
        let (Some(first), Some(last)) = (self.poses.front(), self.poses.back()) else {
            return Err(PoseGap::Empty);
        };
        if time_s.is_nan() || time_s < first.time_s {
            return Err(PoseGap::TooOld);
        }
        if time_s > last.time_s + self.ahead_s {
            return Err(PoseGap::TooNew);
        }
        let after = self.poses.partition_point(|pose| pose.time_s <= time_s).min(self.poses.len() - 1);
        let Some(before) = after.checked_sub(1) else {
            return Ok(StampedPose { time_s, ..*first });
        };
        let (a, b) = (&self.poses[before], &self.poses[after]);
        if b.time_s - a.time_s > self.longest_gap_s && time_s > a.time_s && time_s < b.time_s {
            return Err(PoseGap::Hole);
        }
        let share = (time_s - a.time_s) / (b.time_s - a.time_s);
        let pos = a.pos + (b.pos - a.pos).scale(share);
        Ok(StampedPose { time_s, quat: turned(a.quat, b.quat, share), pos })
    }
}

/// `share` of the way from one orientation to another along the shorter great circle; beyond 1 it continues.
pub fn turned(from: Quat<f64>, to: Quat<f64>, share: f64) -> Quat<f64> {
    let mut dot: f64 = (0..4).map(|k| from.0[k] * to.0[k]).sum();
    let sign = if dot < 0.0 { -1.0 } else { 1.0 };
    dot = (dot * sign).min(1.0);
    let angle = dot.acos();
    let [a, b] = if angle < 1e-6 {
        [1.0 - share, share]
    } else {
        [((1.0 - share) * angle).sin() / angle.sin(), (share * angle).sin() / angle.sin()]
    };
    Quat([0, 1, 2, 3].map(|k| a * from.0[k] + sign * b * to.0[k])).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stamped(time_s: f64, x: f64, yaw: f64) -> StampedPose {
        let quat = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), yaw);
        StampedPose { time_s, quat, pos: Vec3([x, 0.0, 0.8]) }
    }

    #[test]
    fn the_robots_camera_looks_down_ahead() {
        let camera = Pose::g1_camera();
        let axis = camera.rot.mul_vec(Vec3([0.0, 0.0, 1.0])).0;
        assert!((axis[0] - 0.83078_f64.cos()).abs() < 1e-9 && (axis[2] + 0.83078_f64.sin()).abs() < 1e-9);
        // Right of the image is right of the robot; the frame is right-handed.
        let [right, down, ahead] = [0, 1, 2].map(|k| camera.rot.col(k));
        assert_eq!(right.0, [0.0, -1.0, 0.0]);
        let cross = right.cross(down);
        assert!((0..3).all(|k| (cross.0[k] - ahead.0[k]).abs() < 1e-12));
        let point = [0.4, -0.3, 1.2];
        let back = camera.inverse().point(camera.point(point));
        assert!((0..3).all(|k| (back[k] - point[k]).abs() < 1e-12));
    }

    #[test]
    fn between_two_poses_the_torso_is_between_them() {
        let mut buffer = PoseBuffer::default();
        assert_eq!(buffer.at(0.0).err(), Some(PoseGap::Empty));
        assert!(buffer.push(stamped(10.0, 1.0, 0.2)) && buffer.push(stamped(10.1, 1.2, 0.6)));
        let middle = buffer.at(10.025).expect("known");
        assert!((middle.pos.x() - 1.05).abs() < 1e-12 && (middle.rot.yaw() - 0.3).abs() < 1e-12);
        // A little ahead the motion continues; further it is unknown, and so is the past.
        let ahead = buffer.at(10.14).expect("within the horizon");
        assert!((ahead.pos.x() - 1.28).abs() < 1e-9 && (ahead.rot.yaw() - 0.76).abs() < 1e-9);
        assert_eq!(buffer.at(10.2).err(), Some(PoseGap::TooNew));
        assert_eq!(buffer.at(9.9).err(), Some(PoseGap::TooOld));
        assert_eq!(buffer.at(f64::NAN).err(), Some(PoseGap::TooOld));
    }

    #[test]
    fn a_hole_in_the_history_is_not_bridged() {
        let mut buffer = PoseBuffer::new(1.0, 0.05).with_longest_gap(0.02);
        assert!(buffer.push(stamped(1.0, 0.0, 0.0)) && buffer.push(stamped(1.01, 0.1, 0.0)));
        assert!(buffer.push(stamped(1.2, 2.0, 0.0)));
        assert!((buffer.at(1.005).expect("known").pos.x() - 0.05).abs() < 1e-12);
        assert_eq!(buffer.at(1.1).err(), Some(PoseGap::Hole));
        assert!((buffer.at(1.2).expect("known").pos.x() - 2.0).abs() < 1e-12);
    }

    #[test]
    fn a_buffer_with_room_does_not_grow() {
        // Half a second at 100 Hz is 51 poses with both ends, and the new one comes before the oldest goes.
        let mut buffer = PoseBuffer::new(0.5, 0.0).with_room(52);
        let room = buffer.poses.capacity();
        assert!(room >= 52 && buffer.at(0.0).err() == Some(PoseGap::Empty));
        assert!((0..500).all(|k| buffer.push(stamped(0.01 * f64::from(k), 0.0, 0.0))));
        assert_eq!(buffer.poses.capacity(), room);
        assert!((50..=51).contains(&buffer.poses.len()), "{}", buffer.poses.len());
    }

    #[test]
    fn late_doubled_and_broken_poses_are_refused_and_a_set_clock_starts_again() {
        let mut buffer = PoseBuffer::default();
        assert!(buffer.push(stamped(10.0, 1.0, 0.0)));
        assert!(!buffer.push(stamped(10.0, 2.0, 0.0)) && !buffer.push(stamped(9.9, 2.0, 0.0)));
        assert!(!buffer.push(stamped(11.0, f64::NAN, 0.0)));
        assert!((buffer.at(10.0).expect("known").pos.x() - 1.0).abs() < 1e-12);
        assert!(buffer.push(stamped(1.0, 3.0, 0.0)));
        assert!((buffer.at(1.0).expect("known").pos.x() - 3.0).abs() < 1e-12);
    }
}
