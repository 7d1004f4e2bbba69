//! Where pelvis and torso are, by odometry and by the inertial sensor.

use paid_lanes::{Mat3, Quat, Vec3};
use paid_policy::Pose;
use paid_track::{PoseBuffer, PoseGap, StampedPose};

use crate::message::{OdometryPose, TorsoPose, quaternion};
use crate::player::{Player, about_z};
use crate::runtime::body::Body;

/// Poses are kept for this long `[s]`: images may be that late.
const KEPT_S: f64 = 0.4;
/// Poses of that time at 500 Hz, and a few: the thread that fills the buffer must not allocate.
const ROOM: usize = 256;

/// A pose of odometry, as the runtime uses it.
#[derive(Clone, Copy, Debug)]
struct Placed {
    stamp_us: u64,
    /// Origin of the pelvis `[m]`.
    position: Vec3<f64>,
}

/// The robot in odometry's frame.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// The pelvis in the inertial sensor's world, whose origin goes with it.
    pelvis: PoseBuffer,
    /// The torso in the same world.
    carried: PoseBuffer,
    /// The torso in odometry's frame.
    torsos: PoseBuffer,
    torso: Option<Pose<f64>>,
    odometry: Option<Placed>,
    /// Number of perception's odometry frame.
    frame: Option<u32>,
    /// Velocity between the last two poses `[m/s]`.
    velocity: Vec3<f64>,
    /// Heading of odometry's frame less the inertial sensor's `[rad]`.
    turn: f64,
}

impl Place {
    pub fn new() -> Self {
        let buffer = || PoseBuffer::new(KEPT_S, 0.0).with_room(ROOM);
        Self {
            pelvis: buffer(),
            carried: buffer(),
            torsos: buffer(),
            torso: None,
            odometry: None,
            frame: None,
            velocity: Vec3::zero(),
            turn: 0.0,
        }
    }

    /// Takes in a pose of the pelvis.
    pub fn odometry(&mut self, pose: OdometryPose) {
        let finite = pose.position.iter().chain(&pose.quaternion).all(|x| x.is_finite());
        if !finite || self.odometry.is_some_and(|old| pose.stamp_us <= old.stamp_us) {
            return;
        }
        let rot = Quat(pose.quaternion).normalize().to_mat();
        if let Some(pelvis) = nearest(&self.pelvis, pose.stamp_us) {
            self.turn = rot.yaw() - pelvis.rot.yaw();
        }
        self.place(Placed { stamp_us: pose.stamp_us, position: Vec3(pose.position) });
    }

    /// Takes in a pose of the torso: the joints of its time give the pelvis's place. True if it is of a new frame, in which nothing of the
    /// old one holds.
    pub fn torso_pose(&mut self, now_us: u64, pose: &TorsoPose) -> bool {
        let finite = pose.position.iter().chain(&pose.quaternion).all(|x| x.is_finite());
        let stamp_us = now_us.saturating_sub(pose.age_us);
        if !finite || self.odometry.is_some_and(|old| stamp_us <= old.stamp_us) {
            return false;
        }
        let Some(carried) = nearest(&self.carried, stamp_us) else { return false };
        let new_frame = self.frame.replace(pose.frame).is_some_and(|old| old != pose.frame);
        if new_frame {
            self.odometry = None;
            self.velocity = Vec3::zero();
        }
        let rot = Quat(pose.quaternion).normalize().to_mat();
        self.turn = rot.yaw() - carried.rot.yaw();
        let position = Vec3(pose.position) - about_z(self.turn).mul_vec(carried.pos);
        self.place(Placed { stamp_us, position });
        new_frame
    }

    fn place(&mut self, placed: Placed) {
        if let Some(old) = self.odometry {
            let dt = (placed.stamp_us - old.stamp_us) as f64 * 1e-6;
            self.velocity = (placed.position - old.position).scale(1.0 / dt);
        }
        self.odometry = Some(placed);
    }

    /// Number of perception's odometry frame, once there is one.
    pub fn frame(&self) -> Option<u32> {
        self.frame
    }

    /// Age of the last pose `[s]`; infinite without one.
    pub fn odometry_age(&self, now_us: u64) -> f64 {
        self.odometry.map_or(f64::INFINITY, |pose| now_us.saturating_sub(pose.stamp_us) as f64 * 1e-6)
    }

    /// The pelvis in odometry's frame: place from odometry, roll and pitch from the inertial sensor.
    pub fn base(&self, now_us: u64, body: &Body) -> Option<Pose<f64>> {
        let placed = self.odometry?;
        let age = self.odometry_age(now_us).min(0.1);
        let rot: Mat3<f64> = about_z(self.turn).mul_mat(&body.base_rot);
        Some(Pose { pos: self.velocity.scale_add(age, placed.position), rot })
    }

    /// Remembers where the torso is now: images of this instant arrive later.
    pub fn remember(&mut self, now_us: u64, body: &Body, player: &Player) {
        let torso = player.anchor_in_base(&body.joint_pos);
        let stamped = |pos: Vec3<f64>, rot: &Mat3<f64>| StampedPose {
            time_s: now_us as f64 * 1e-6,
            quat: Quat(quaternion(rot)),
            pos,
        };
        self.pelvis.push(stamped(Vec3::zero(), &body.base_rot));
        let carried = body.base_rot.mul_mat(&torso.rot);
        self.carried.push(stamped(body.base_rot.mul_vec(torso.pos), &carried));
        self.torso = self
            .base(now_us, body)
            .map(|base| Pose { pos: base.point_in_world(torso.pos), rot: base.rot.mul_mat(&torso.rot) });
        if let Some(torso) = &self.torso {
            self.torsos.push(stamped(torso.pos, &torso.rot));
        }
    }

    /// The torso now, in odometry's frame.
    pub fn torso(&self) -> Option<Pose<f64>> {
        self.torso
    }

    /// The torso at a time, in odometry's frame; now for a time that is yet to come.
    pub fn torso_at(&self, at_us: u64) -> Option<paid_track::Pose> {
        nearest(&self.torsos, at_us)
    }
}

/// A pose at a time; the newest one for a time after it.
fn nearest(poses: &PoseBuffer, at_us: u64) -> Option<paid_track::Pose> {
    match poses.at(at_us as f64 * 1e-6) {
        Ok(pose) => Some(pose),
        Err(PoseGap::TooNew) => poses.last().map(StampedPose::pose),
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_that_is_no_number_or_older_is_not_taken() {
        let mut place = Place::new();
        let pose = |stamp_us, x| OdometryPose {
            stamp_us,
            position: [x, 0.0, 0.7],
            quaternion: [1.0, 0.0, 0.0, 0.0],
        };
        place.odometry(pose(1000, 1.0));
        place.odometry(pose(2000, f64::NAN));
        place.odometry(pose(500, 9.0));
        let base = place.base(1000, &Body::new(29)).expect("a pose");
        assert_eq!(base.pos.0, [1.0, 0.0, 0.7]);
        assert!((place.odometry_age(51_000) - 0.05).abs() < 1e-12);
    }
}
