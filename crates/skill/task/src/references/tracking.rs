//! Differences between robot and reference, computed once per control step: reward terms and the log read them.

use paid_lanes::{Mat3, Real, Vec3};
use paid_physics::GroupState;

use crate::config::TaskConfig;
use crate::references::frame::Reference;

/// Tracking errors that are logged, in the order of [`crate::TaskMetrics::tracking`]: anchor position `[m]` and orientation `[rad]`,
/// mean body position `[m]` and orientation `[rad]` (yaw-aligned), mean body linear `[m/s]` and angular `[rad/s]` velocity,
/// norm of the joint angle `[rad]` and joint velocity `[rad/s]` errors.
pub const TRACKING_NAMES: [&str; 8] = [
    "error_anchor_pos",
    "error_anchor_ori",
    "error_body_pos",
    "error_body_ori",
    "error_body_lin_vel",
    "error_body_ang_vel",
    "error_joint_pos",
    "error_joint_vel",
];

/// Differences of one body from the yaw-aligned reference.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyError<V> {
    /// Squared distance `[m^2]`.
    pub pos2: V,
    /// Angle between the orientations `[rad]`.
    pub angle: V,
    /// Squared difference of the velocities of the center of mass, world axes `[m^2/s^2]`.
    pub lin2: V,
    /// Squared difference of the angular velocities, world axes `[rad^2/s^2]`.
    pub ang2: V,
}

/// Differences of a group's robots from their references.
#[derive(Clone, Debug)]
pub(crate) struct TrackingErrors<V> {
    /// Squared distance of the anchor, world `[m^2]`.
    pub anchor_pos2: V,
    /// Angle between the anchor's orientations `[rad]`.
    pub anchor_angle: V,
    /// Each followed body; the tracked ones come first.
    pub bodies: Vec<BodyError<V>>,
    tracked: usize,
}

impl<V: Real> TrackingErrors<V> {
    /// No difference at all.
    pub(crate) fn new(config: &TaskConfig) -> Self {
        let zero = V::zero();
        let body = BodyError { pos2: zero, angle: zero, lin2: zero, ang2: zero };
        Self {
            anchor_pos2: zero,
            anchor_angle: zero,
            bodies: vec![body; config.followed.len()],
            tracked: config.tracked,
        }
    }

    /// The tracked bodies.
    #[inline(always)]
    pub(crate) fn tracked(&self) -> &[BodyError<V>] {
        &self.bodies[..self.tracked]
    }

    /// Takes in the state and the reference frame that it is scored against.
    #[inline(always)]
    pub(crate) fn update(&mut self, config: &TaskConfig, state: &GroupState<V>, reference: &Reference<V>) {
        let anchor = &state.bodies[config.followed[config.anchor]];
        let (target_pos, target_rot) = (reference.pos(config.anchor), reference.rot(config.anchor));
        let turn = if config.preset.rewards.align_yaw {
            yaw_alignment(&anchor.rot, &target_rot)
        } else {
            Mat3::identity()
        };
        self.anchor_pos2 = (anchor.pos - target_pos).norm2();
        self.anchor_angle = orientation_error(&anchor.rot, &target_rot);
        for (i, error) in self.bodies.iter_mut().enumerate() {
            let body = &state.bodies[config.followed[i]];
            let target = aligned_position(&turn, anchor.pos, target_pos, reference.pos(i));
            *error = BodyError {
                pos2: (body.pos - target).norm2(),
                angle: orientation_error(&body.rot, &turn.mul_mat(&reference.rot(i))),
                lin2: (body.com_vel - reference.com_vel(i)).norm2(),
                ang2: (body.ang_vel - reference.ang_vel(i)).norm2(),
            };
        }
    }

    /// What is logged, in the order of [`TRACKING_NAMES`].
    #[inline(always)]
    pub(crate) fn logged(
        &self,
        config: &TaskConfig,
        state: &GroupState<V>,
        reference: &Reference<V>,
    ) -> [V; TRACKING_NAMES.len()] {
        let (mut pos, mut angle, mut lin, mut ang) = (V::zero(), V::zero(), V::zero(), V::zero());
        for body in self.tracked() {
            pos += body.pos2.sqrt();
            angle += body.angle;
            lin += body.lin2.sqrt();
            ang += body.ang2.sqrt();
        }
        let (mut joint2, mut speed2) = (V::zero(), V::zero());
        for j in 0..config.joints() {
            let m = config.to_model[j];
            let d = state.joint_pos[m] - reference.joint_pos(j);
            let v = state.joint_vel[m] - reference.joint_vel(j);
            joint2 = d.mul_add(d, joint2);
            speed2 = v.mul_add(v, speed2);
        }
        let share = V::c(1.0 / self.tracked as f64);
        [
            self.anchor_pos2.sqrt(),
            self.anchor_angle,
            pos * share,
            angle * share,
            lin * share,
            ang * share,
            joint2.sqrt(),
            speed2.sqrt(),
        ]
    }
}

/// Rotation about z that turns the reference's heading into the robot's: the yaw of (robot anchor x inverse reference anchor).
#[inline(always)]
fn yaw_alignment<V: Real>(robot_anchor: &Mat3<V>, reference_anchor: &Mat3<V>) -> Mat3<V> {
    robot_anchor.mul_mat(&reference_anchor.transpose()).yaw_only()
}

/// A reference position as the robot should have it: turned about the anchor, placed at the robot anchor's x, y and the
/// reference's z.
#[inline(always)]
fn aligned_position<V: Real>(
    alignment: &Mat3<V>,
    robot_anchor: Vec3<V>,
    reference_anchor: Vec3<V>,
    reference: Vec3<V>,
) -> Vec3<V> {
    let turned = alignment.mul_vec(reference - reference_anchor);
    Vec3::new(robot_anchor.x() + turned.x(), robot_anchor.y() + turned.y(), reference.z())
}

/// Angle between two orientations `[rad]`.
#[inline(always)]
fn orientation_error<V: Real>(a: &Mat3<V>, b: &Mat3<V>) -> V {
    a.tr_mul_mat(b).angle()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::{Fixture, close};
    use core::f64::consts::FRAC_PI_2;
    use paid_lanes::Quat;

    fn yaw(angle: f64) -> Mat3<f64> {
        Quat::from_roll_pitch_yaw(0.0, 0.0, angle).to_mat()
    }

    #[test]
    fn alignment_takes_only_the_heading() {
        let tilted: Mat3<f64> = Quat::from_roll_pitch_yaw(0.0, 0.4, 0.0).to_mat();
        let robot = yaw(FRAC_PI_2).mul_mat(&tilted);
        let alignment = yaw_alignment(&robot, &tilted);
        let x = alignment.mul_vec(Vec3([1.0, 0.0, 0.0])).0;
        assert!(x[0].abs() < 1e-9 && (x[1] - 1.0).abs() < 1e-9 && x[2].abs() < 1e-12);
    }

    #[test]
    fn an_aligned_target_turns_about_the_anchor_and_keeps_its_height() {
        let target = aligned_position(
            &yaw(FRAC_PI_2),
            Vec3([5.0, 6.0, 0.9]),
            Vec3([1.0, 1.0, 0.8]),
            Vec3([2.0, 1.0, 0.1]),
        );
        let expected = [5.0, 7.0, 0.1];
        for k in 0..3 {
            assert!((target.0[k] - expected[k]).abs() < 1e-12);
        }
    }

    #[test]
    fn orientation_error_is_the_angle_between() {
        assert!((orientation_error(&yaw(0.3), &yaw(-0.4)) - 0.7).abs() < 1e-12);
    }

    #[test]
    fn without_alignment_a_robot_that_heads_elsewhere_is_wrong_by_its_heading() {
        for (align_yaw, angle) in [(true, 0.0), (false, 0.5)] {
            let Fixture { mut config, mut state, group, mut tracking, .. } = Fixture::new();
            config.preset.rewards.align_yaw = align_yaw;
            for body in &config.followed {
                state.bodies[*body].rot = yaw(0.5);
            }
            tracking.update(&config, &state, &group.reference);
            for body in tracking.tracked() {
                close(body.angle, angle);
            }
        }
    }

    /// The reference lies in the origin, at rest; the robot's anchor is there too.
    #[test]
    fn each_error_is_the_bodys_own_and_the_log_has_their_means() {
        let Fixture { config, mut state, group, mut tracking, .. } = Fixture::new();
        let body = (0..config.tracked).find(|i| *i != config.anchor).expect("another body");
        let moved = &mut state.bodies[config.followed[body]];
        moved.pos = Vec3([0.3, 0.0, 0.4]);
        moved.rot = yaw(0.5);
        moved.com_vel = Vec3([0.0, 2.0, 0.0]);
        moved.ang_vel = Vec3([0.0, 0.0, -3.0]);
        state.joint_pos[4] = -0.25;
        state.joint_vel[9] = 1.5;
        tracking.update(&config, &state, &group.reference);
        let error = tracking.bodies[body];
        for (found, expected) in [
            (error.pos2, 0.25),
            (error.angle, 0.5),
            (error.lin2, 4.0),
            (error.ang2, 9.0),
            (tracking.anchor_pos2, 0.0),
        ] {
            close(found, expected);
        }
        let n = config.tracked as f64;
        let logged = tracking.logged(&config, &state, &group.reference);
        for (found, expected) in
            logged.into_iter().zip([0.0, 0.0, 0.5 / n, 0.5 / n, 2.0 / n, 3.0 / n, 0.25, 1.5])
        {
            close(found, expected);
        }
    }
}
