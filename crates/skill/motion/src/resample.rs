//! A clip at another frame rate.

use paid_lanes::{Quat, Vec3};
use paid_robot::RobotModel;

use crate::{Clip, rotation_log, slerp};

/// The clip at `rate_hz` frames a second, from its first frame on, never past its last.
///
/// Angles and positions are interpolated linearly, orientations along the shorter arc. Velocities are not
/// interpolated but recomputed as central differences (one-sided at the ends) of the new frames; linear velocity is
/// that of the center of mass, which needs the robot's model.
pub fn resample(clip: &Clip, model: &RobotModel, rate_hz: f64) -> Clip {
    let last = clip.frames - 1;
    // A hair of tolerance keeps the last frame when both rates divide the duration.
    let frames = (last as f64 * rate_hz / clip.fps + 1e-9).floor() as usize + 1;
    let mut out = Clip {
        fps: rate_hz,
        frames,
        kick_frame: clip
            .kick_frame
            .map(|k| ((k as f64 * rate_hz / clip.fps).round() as usize).min(frames.saturating_sub(1))),
        joint_pos: Vec::with_capacity(frames * clip.joints),
        body_pos: Vec::with_capacity(frames * clip.bodies),
        body_quat: Vec::with_capacity(frames * clip.bodies),
        joint_vel: Vec::new(),
        body_lin_vel: Vec::new(),
        body_ang_vel: Vec::new(),
        ..clip.clone()
    };
    for t in 0..frames {
        let time = (t as f64 * clip.fps / rate_hz).min(last as f64);
        let a = (time.floor() as usize).min(last);
        let b = (a + 1).min(last);
        let s = time - a as f64;
        let mix = |x: f64, y: f64| x + (y - x) * s;
        out.joint_pos.extend(clip.joint_pos(a).iter().zip(clip.joint_pos(b)).map(|(x, y)| mix(*x, *y)));
        for i in 0..clip.bodies {
            let (p, q) = (clip.body_pos(a)[i], clip.body_pos(b)[i]);
            out.body_pos.push([mix(p[0], q[0]), mix(p[1], q[1]), mix(p[2], q[2])]);
            out.body_quat.push(slerp(clip.body_quat(a)[i], clip.body_quat(b)[i], s));
        }
    }
    differentiate(&mut out, model);
    out
}

/// Recomputes all velocities of a clip from its angles and poses.
pub(crate) fn differentiate(clip: &mut Clip, model: &RobotModel) {
    let (mut joint_vel, mut lin_vel, mut ang_vel) = (Vec::new(), Vec::new(), Vec::new());
    for t in 0..clip.frames {
        let (a, b) = (t.saturating_sub(1), (t + 1).min(clip.frames - 1));
        let dt = (b - a) as f64 / clip.fps;
        // A clip of a single frame stands still.
        let rate = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        joint_vel.extend(clip.joint_pos(a).iter().zip(clip.joint_pos(b)).map(|(x, y)| (y - x) * rate));
        for (i, body) in model.bodies.iter().enumerate() {
            let com =
                |t: usize| Quat(clip.body_quat(t)[i]).rotate(Vec3(body.com)) + Vec3(clip.body_pos(t)[i]);
            lin_vel.push((com(b) - com(a)).scale(rate).0);
            ang_vel.push(rotation_log(clip.body_quat(a)[i], clip.body_quat(b)[i]).map(|x| x * rate));
        }
    }
    (clip.joint_vel, clip.body_lin_vel, clip.body_ang_vel) = (joint_vel, lin_vel, ang_vel);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{model, steady_clip};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn steady_motion_keeps_its_speed_at_any_rate(rate in 10.0..200.0_f64, turn in -3.0..3.0_f64) {
            let clip = steady_clip(41, 50.0, turn);
            let out = resample(&clip, &model(), rate);
            prop_assert!(out.duration_s() <= clip.duration_s() + 1e-9);
            prop_assert!(out.duration_s() > clip.duration_s() - 1.0 / rate);
            for t in 0..out.frames {
                let time = t as f64 / rate;
                prop_assert!((out.joint_pos(t)[1] - 0.5 * time).abs() < 1e-9);
                prop_assert!((out.joint_vel(t)[1] - 0.5).abs() < 1e-6);
                prop_assert!((out.body_ang_vel(t)[0][2] - turn).abs() < 1e-6);
                // The center of mass of body 0 is on its z axis, so turning about z does not move it.
                prop_assert!((out.body_lin_vel(t)[0][0] - 1.0).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_sine_of_30_hz_is_a_sine_at_50_as_near_as_straight_lines_come() {
        let sine = |t: f64| (std::f64::consts::TAU * t).sin();
        let mut clip = steady_clip(61, 30.0, 0.0);
        let joints = clip.joints;
        for t in 0..clip.frames {
            clip.joint_pos[t * joints] = sine(t as f64 / 30.0);
        }
        let out = resample(&clip, &model(), 50.0);
        assert_eq!(out.frames, 101);
        let worst =
            (0..out.frames).map(|t| (out.joint_pos(t)[0] - sine(t as f64 / 50.0)).abs()).fold(0.0, f64::max);
        // A chord of 1/30 s lies at most (2 pi)^2 / 8 / 900 = 0.00548 below its arc.
        assert!((0.003..0.005_49).contains(&worst), "{worst}");
    }

    #[test]
    fn orientations_whose_sign_changes_from_frame_to_frame_are_the_same_motion() {
        let clip = steady_clip(41, 30.0, 2.0);
        let mut flipped = clip.clone();
        for t in (1..clip.frames).step_by(2) {
            for quat in &mut flipped.body_quat[t * clip.bodies..(t + 1) * clip.bodies] {
                *quat = quat.map(|x| -x);
            }
        }
        let (plain, flipped) = (resample(&clip, &model(), 50.0), resample(&flipped, &model(), 50.0));
        for (a, b) in plain.body_quat.iter().zip(&flipped.body_quat) {
            let dot: f64 = a.iter().zip(b).map(|(x, y)| x * y).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-12, "{a:?} {b:?}");
        }
        for (a, b) in plain.body_ang_vel.iter().zip(&flipped.body_ang_vel) {
            assert!(a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-9), "{a:?} {b:?}");
        }
    }

    #[test]
    fn a_turning_body_moves_its_center_of_mass() {
        // Body 1 has its center of mass 0.1 m along x from its origin and turns at 2 rad/s about z.
        let mut clip = steady_clip(201, 1000.0, 2.0);
        differentiate(&mut clip, &model());
        let v = clip.body_lin_vel(100)[1];
        let angle: f64 = 2.0 * 0.1;
        assert!((v[0] - (1.0 - 0.2 * angle.sin())).abs() < 1e-5, "{v:?}");
        assert!((v[1] - 0.2 * angle.cos()).abs() < 1e-5, "{v:?}");
    }
}
