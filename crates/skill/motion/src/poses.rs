//! A clip from what most formats and solvers give: the base's poses and the joint angles.

use std::path::PathBuf;

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, kinematics};

use crate::generate::Pose;
use crate::resample::differentiate;
use crate::{Clip, KickLeg};

/// Position `[m]` and unit quaternion (w, x, y, z) of the base.
pub(crate) type Base = ([f64; 3], [f64; 4]);

impl Clip {
    /// The poses of its frames.
    pub(crate) fn poses(&self) -> impl Iterator<Item = Pose> {
        (0..self.frames).map(|t| Pose {
            base_pos: self.body_pos(t)[0],
            base_quat: self.body_quat(t)[0],
            joints: self.joint_pos(t).to_vec(),
        })
    }

    /// As [`Clip::from_poses`], of poses.
    pub(crate) fn of_poses(model: &RobotModel, fps: f64, poses: &[Pose]) -> Self {
        let base: Vec<_> = poses.iter().map(|p| (p.base_pos, p.base_quat)).collect();
        let joints: Vec<f64> = poses.iter().flat_map(|p| p.joints.iter().copied()).collect();
        Self::from_poses(model, fps, &base, &joints)
    }

    /// A clip of `base` (world position `[m]`, unit quaternion w, x, y, z) `[T]` and joint angles `[T, J]` `[rad]`, model order. Body poses
    /// come from forward kinematics, velocities from central differences; name, path and labels are for the caller to fill in.
    ///
    /// # Panics
    /// If there is no frame, or not one angle a joint and frame.
    pub fn from_poses(
        model: &RobotModel,
        fps: f64,
        base: &[([f64; 3], [f64; 4])],
        joint_pos: &[f64],
    ) -> Self {
        let joints = model.joints.len();
        assert!(!base.is_empty() && joint_pos.len() == base.len() * joints, "one angle a joint and frame");
        let mut clip = Self {
            name: String::new(),
            path: PathBuf::new(),
            fps,
            kick_leg: KickLeg::Right,
            kick_frame: None,
            license: None,
            frames: base.len(),
            joints,
            bodies: model.bodies.len(),
            joint_pos: joint_pos.to_vec(),
            joint_vel: Vec::new(),
            body_pos: Vec::new(),
            body_quat: Vec::new(),
            body_lin_vel: Vec::new(),
            body_ang_vel: Vec::new(),
        };
        for (&(pos, quat), angles) in base.iter().zip(joint_pos.chunks_exact(joints.max(1))) {
            for (i, pose) in
                kinematics::forward::<f64>(model, Vec3(pos), Quat(quat), angles).iter().enumerate()
            {
                clip.body_pos.push(pose.pos.0);
                clip.body_quat.push(if i == 0 { quat } else { pose.quat.0 });
            }
        }
        differentiate(&mut clip, model);
        clip
    }
}
