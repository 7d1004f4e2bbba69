//! Two joints, two bodies and numbers that differ everywhere, for the terms' tests.

use paid_lanes::{Mat3, Vec3};

use super::Observation;
use crate::{Pose, PrivilegedView, ReferenceView, RobotView, SceneView, Views};

/// A quarter turn to the left: x of the body is y of the world.
pub(super) const LEFT: Mat3<f64> = Mat3([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]);

pub(super) struct Fixture {
    bodies: [Pose<f64>; 2],
}

impl Fixture {
    pub(super) fn new() -> Self {
        let at = |pos, rot| Pose { pos: Vec3(pos), rot };
        Self { bodies: [at([1.0, 2.0, 0.8], LEFT), at([1.0, 2.5, 0.1], Mat3::identity())] }
    }

    pub(super) fn views(&self) -> Views<'_, f64> {
        Views {
            robot: RobotView {
                base_rot: LEFT,
                base_ang_vel: Vec3([0.1, 0.2, 0.3]),
                joint_pos_rel: &[0.5, -0.6],
                joint_vel: &[1.5, -1.6],
                last_action: &[2.5, -2.6],
            },
            privileged: Some(PrivilegedView {
                base_lin_vel: Vec3([0.7, 0.8, 0.9]),
                anchor: self.bodies[0],
                bodies: &self.bodies,
            }),
            reference: Some(ReferenceView {
                joint_pos: &[3.5, -3.6],
                joint_vel: &[4.5, -4.6],
                anchor: Pose { pos: Vec3([1.0, 3.0, 0.9]), rot: Mat3::identity() },
                anchor_ang_vel: Vec3([0.4, 0.5, 0.6]),
            }),
            scene: Some(SceneView {
                ball: Vec3([1.1, 1.2, -0.6]),
                ball_at_strike: Vec3([2.1, 2.2, -0.7]),
                goal: Vec3([5.1, 5.2, -0.5]),
            }),
        }
    }
}

/// What a term writes for the fixture.
pub(super) fn written<T: Observation>() -> Vec<f64> {
    let mut out = Vec::new();
    T::write(&Fixture::new().views(), &mut out);
    out
}
