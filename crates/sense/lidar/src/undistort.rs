//! Removes the sensor's own motion from a scan: every point is moved to where it would have been seen at the scan's end.
//!
//! Source of the method: FAST-LIO2, section IV-B (backward propagation).

use nalgebra::{Isometry3, Translation3, UnitQuaternion, Vector3};

use crate::propagate::Step;
use crate::scan::Point;
use crate::so3::exp;
use crate::state::State;

/// Motion of the IMU from one sample to the next.
#[derive(Clone, Debug)]
struct Segment {
    start_s: f64,
    position: Vector3<f64>,
    rotation: UnitQuaternion<f64>,
    velocity: Vector3<f64>,
    accel: Vector3<f64>,
    gyro: Vector3<f64>,
}

impl Segment {
    fn odometry_from_imu(&self, time_s: f64) -> Isometry3<f64> {
        let dt = time_s - self.start_s;
        let position = self.position + self.velocity * dt + self.accel * (0.5 * dt * dt);
        Isometry3::from_parts(Translation3::from(position), self.rotation * exp(&(self.gyro * dt)))
    }
}

/// The predicted motion of the IMU over one scan.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    segments: Vec<Segment>,
}

impl Motion {
    /// Forgets the last scan; keeps the memory.
    pub fn clear(&mut self) {
        self.segments.clear();
    }

    /// Adds a step of the prediction that began at `start_s` in `state`.
    pub fn push(&mut self, start_s: f64, state: &State, step: &Step) {
        self.segments.push(Segment {
            start_s,
            position: state.position,
            rotation: state.rotation,
            velocity: state.velocity,
            accel: step.accel,
            gyro: step.gyro,
        });
    }

    /// Writes the points in the LiDAR frame at the scan's end to `out`. `end` is the predicted state there, `start_s` the scan's begin.
    pub fn undistort(&self, points: &[Point], start_s: f64, end: &State, out: &mut Vec<Vector3<f64>>) {
        out.clear();
        let imu_from_lidar = end.imu_from_lidar();
        let lidar_from_odometry = (end.odometry_from_imu() * imu_from_lidar).inverse();
        let mut at = 0;
        for point in points {
            let time_s = start_s + point.offset_s;
            // Points come nearly in order, so the segment is the last one or a neighbor.
            while at > 0 && self.segments[at].start_s > time_s {
                at -= 1;
            }
            while at + 1 < self.segments.len() && self.segments[at + 1].start_s <= time_s {
                at += 1;
            }
            let Some(segment) = self.segments.get(at) else {
                out.push(point.position);
                continue;
            };
            let seen = imu_from_lidar.rotation * point.position + imu_from_lidar.translation.vector;
            let dt = time_s - segment.start_s;
            let turn = segment.gyro * dt;
            // Within one sample a turn is below 0.1 rad: the second order of the exponential is exact to 2e-4 of the range there
            // and to 1e-6 at walking speed.
            let turned = if turn.norm_squared() < 1e-3 {
                let once = turn.cross(&seen);
                seen + once + turn.cross(&once) * 0.5
            } else {
                exp(&turn) * seen
            };
            let position = segment.position + segment.velocity * dt + segment.accel * (0.5 * dt * dt);
            let in_odometry = segment.rotation * turned + position;
            out.push(lidar_from_odometry.rotation * in_odometry + lidar_from_odometry.translation.vector);
        }
    }

    /// Predicted poses of the IMU at the begin of every step, with their times `[s]`.
    pub fn poses(&self) -> impl Iterator<Item = (f64, Isometry3<f64>)> + '_ {
        self.segments.iter().map(|segment| (segment.start_s, segment.odometry_from_imu(segment.start_s)))
    }

    /// Predicted pose of the IMU at `time_s`, or `None` if nothing was predicted.
    #[must_use]
    pub fn odometry_from_imu(&self, time_s: f64) -> Option<Isometry3<f64>> {
        let at = self.segments.partition_point(|s| s.start_s <= time_s);
        self.segments.get(at.saturating_sub(1)).map(|s| s.odometry_from_imu(time_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::imu::ImuSample;

    #[test]
    fn a_wall_seen_while_turning_and_driving_is_flat_again() {
        // 1 rad/s about z, 2 m/s along x, a wall at x = 5 m in the odometry frame, LiDAR 0.1 m ahead of the IMU.
        let mut state =
            State { velocity: Vector3::x() * 2.0, lidar_position: Vector3::x() * 0.1, ..State::default() };
        let sample = |time_s: f64, state: &State| ImuSample {
            time_s,
            gyro: Vector3::z(),
            accel: state.rotation.inverse() * Vector3::z() * 9.81,
        };
        let mut motion = Motion::default();
        let mut points = Vec::new();
        for i in 0..20 {
            let start_s = f64::from(i) * 0.005;
            for k in 0..5 {
                let time_s = start_s + f64::from(k) * 0.001;
                let rotation = exp(&(Vector3::z() * time_s));
                let origin = Vector3::x() * (2.0 * time_s) + rotation * Vector3::x() * 0.1;
                let hit = Vector3::new(5.0, f64::from(i) * 0.1 - 1.0, f64::from(k) * 0.2);
                points.push(Point { offset_s: time_s, position: rotation.inverse() * (hit - origin) });
            }
            let step = Step::new(&state, &sample(start_s, &state), &sample(start_s + 0.005, &state));
            motion.push(start_s, &state, &step);
            state = step.apply(&state);
        }
        let mut out = Vec::new();
        motion.undistort(&points, 0.0, &state, &mut out);
        let worst = out
            .iter()
            .map(|p| {
                let p = state.odometry_from_imu() * state.imu_from_lidar() * nalgebra::Point3::from(*p);
                (p.x - 5.0).abs()
            })
            .fold(0.0, f64::max);
        let raw = points.iter().map(|p| (p.position.x + 0.1 - 5.0).abs()).fold(0.0, f64::max);
        assert!(worst < 1e-5, "{worst} m after, {raw} m before");
        assert!(raw > 0.1);
    }
}
