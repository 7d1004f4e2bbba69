//! Forward kinematics: where every body is, and how it moves.
//!
//! Written over [`Real`]: exact in `f64`, or one environment per lane.

use paid_lanes::{Mat3, Quat, Real, Vec3};

use crate::{RobotModel, WorldAngVel};

/// Pose of a body in the world.
#[derive(Clone, Copy, Debug)]
pub struct BodyPose<V> {
    /// Origin of the body frame `[m]`.
    pub pos: Vec3<V>,
    /// Orientation: world from body.
    pub quat: Quat<V>,
}

/// Velocity of a body in world axes.
#[derive(Clone, Copy, Debug)]
pub struct BodyVelocity<V> {
    /// Of the body frame's origin `[m/s]`.
    pub origin: Vec3<V>,
    /// Of the center of mass `[m/s]`; motion files store this one.
    pub com: Vec3<V>,
    /// Angular velocity `[rad/s]`.
    pub ang: WorldAngVel<V>,
}

impl<V: Real> BodyPose<V> {
    /// The orientation as a matrix, world from body.
    #[inline(always)]
    pub fn rot(&self) -> Mat3<V> {
        self.quat.to_mat()
    }

    /// A point of the body [m, body frame] in the world.
    #[inline(always)]
    pub fn point(&self, in_body: Vec3<V>) -> Vec3<V> {
        self.pos + self.quat.rotate(in_body)
    }
}

/// Poses of all bodies, model order, from the base's pose (`base_quat` of unit norm) and the joint angles `[rad]`, model order.
///
/// # Panics
/// If `joint_pos` does not have one angle per joint.
pub fn forward<V: Real>(
    model: &RobotModel,
    base_pos: Vec3<V>,
    base_quat: Quat<V>,
    joint_pos: &[V],
) -> Vec<BodyPose<V>> {
    assert_eq!(joint_pos.len(), model.joints.len(), "one angle per joint");
    let mut poses = Vec::with_capacity(model.bodies.len());
    poses.push(BodyPose { pos: base_pos, quat: base_quat });
    for (joint, &angle) in model.joints.iter().zip(joint_pos) {
        let body = &model.bodies[joint.body];
        let parent: BodyPose<V> = poses[body.parent.unwrap_or(0)];
        let turn = Quat::from_axis_angle(Vec3::c(joint.axis), angle);
        let quat = parent.quat.mul(Quat::c(body.quat)).mul(turn).normalize();
        poses.push(BodyPose { pos: parent.point(Vec3::c(body.pos)), quat });
    }
    poses
}

/// Velocities of all bodies, model order, from the poses that [`forward`] found, the velocity of the base's origin `[m/s]`
/// and its angular velocity, and the joint velocities `[rad/s]`, model order.
///
/// # Panics
/// If `poses` or `joint_vel` do not fit the model.
pub fn forward_velocity<V: Real>(
    model: &RobotModel,
    poses: &[BodyPose<V>],
    base_lin_vel: Vec3<V>,
    base_ang_vel: WorldAngVel<V>,
    joint_vel: &[V],
) -> Vec<BodyVelocity<V>> {
    assert_eq!(poses.len(), model.bodies.len(), "one pose a body");
    assert_eq!(joint_vel.len(), model.joints.len(), "one velocity per joint");
    let with_com = |body: usize, origin: Vec3<V>, ang: Vec3<V>| {
        let arm = poses[body].quat.rotate(Vec3::c(model.bodies[body].com));
        BodyVelocity { origin, com: ang.cross_add(arm, origin), ang: WorldAngVel(ang) }
    };
    let mut velocities = Vec::with_capacity(poses.len());
    velocities.push(with_com(0, base_lin_vel, base_ang_vel.0));
    for (joint, &speed) in model.joints.iter().zip(joint_vel) {
        let parent = model.bodies[joint.body].parent.unwrap_or(0);
        let BodyVelocity { origin, ang: WorldAngVel(turning), .. } = velocities[parent];
        let origin = turning.cross_add(poses[joint.body].pos - poses[parent].pos, origin);
        let axis = poses[joint.body].quat.rotate(Vec3::c(joint.axis));
        velocities.push(with_com(joint.body, origin, axis.scale_add(speed, turning)));
    }
    velocities
}

/// Velocity of a body's origin, given that of its center of mass (as motion files store it) `[m/s]`.
#[inline(always)]
pub fn origin_velocity<V: Real>(
    model: &RobotModel,
    body: usize,
    pose: &BodyPose<V>,
    com_vel: Vec3<V>,
    ang_vel: WorldAngVel<V>,
) -> Vec3<V> {
    com_vel - ang_vel.0.cross(pose.quat.rotate(Vec3::c(model.bodies[body].com)))
}
