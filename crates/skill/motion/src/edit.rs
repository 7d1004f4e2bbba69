//! Small changes of whole clips: a part of one, its mirror image, one after another.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec};

use crate::generate::{Biped, GenerateError, Pose, mirrored};
use crate::{Clip, KickLeg, fastest_kick};

fn rebuilt(clip: &Clip, model: &RobotModel, poses: &[Pose]) -> Clip {
    Clip {
        name: clip.name.clone(),
        path: clip.path.clone(),
        license: clip.license.clone(),
        kick_leg: clip.kick_leg,
        kick_frame: clip.kick_frame,
        ..Clip::of_poses(model, clip.fps, poses)
    }
}

/// The frames from second `from_s` to second `to_s`, both cut to the clip (`to_s` may be infinite: to its end); `None` if fewer than 3
/// are left, or of times that are negative or no numbers.
pub fn cut(clip: &Clip, model: &RobotModel, from_s: f64, to_s: f64) -> Option<Clip> {
    if !from_s.is_finite() || from_s < 0.0 || to_s.is_nan() || to_s < 0.0 {
        return None;
    }
    let frame = |s: f64| ((s * clip.fps).round().max(0.0) as usize).min(clip.frames - 1);
    let (a, b) = (frame(from_s), frame(to_s) + 1);
    if b < a + 3 {
        return None;
    }
    let part: Vec<Pose> = clip.poses().skip(a).take(b - a).collect();
    let kick_frame = clip.kick_frame.filter(|k| (a..b).contains(k)).map(|k| k - a);
    Some(Clip { kick_frame, ..rebuilt(clip, model, &part) })
}

/// The mirror image in the x-z plane: a left-footed kick of a right-footed one.
///
/// # Errors
/// A robot whose left and right are no images of each other.
pub fn mirror(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Result<Clip, GenerateError> {
    let figure = Biped::new(model, spec)?;
    let image: Vec<Pose> = clip.poses().map(|pose| mirrored(&figure, &pose)).collect();
    let kick_leg = match clip.kick_leg {
        KickLeg::Left => KickLeg::Right,
        KickLeg::Right => KickLeg::Left,
    };
    Ok(Clip { kick_leg, ..rebuilt(clip, model, &image) })
}

/// One clip after another: the second is turned about the vertical and moved over the floor so that its first base stands where the
/// first one's last does. Both must have one frame rate (see [`crate::resample()`]); `None` otherwise. What jumps at the seam is for
/// [`crate::clean`] to smooth.
pub fn join(first: &Clip, second: &Clip, model: &RobotModel) -> Option<Clip> {
    if (first.fps - second.fps).abs() > 1e-9 * first.fps || first.joints != second.joints {
        return None;
    }
    let last = first.frames - 1;
    let (from, to) = (Quat(second.body_quat(0)[0]), Quat(first.body_quat(last)[0]));
    let turn = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), to.to_mat().yaw() - from.to_mat().yaw());
    let (start, end) = (Vec3(second.body_pos(0)[0]), Vec3(first.body_pos(last)[0]));
    let moved = second.poses().skip(1).map(|pose| {
        let way = turn.rotate(Vec3(pose.base_pos) - start);
        Pose {
            base_pos: [end.x() + way.x(), end.y() + way.y(), pose.base_pos[2]],
            base_quat: turn.mul(Quat(pose.base_quat)).normalize().0,
            joints: pose.joints,
        }
    });
    let all: Vec<Pose> = first.poses().chain(moved).collect();
    let license = match (&first.license, &second.license) {
        (Some(a), Some(b)) if a != b => Some(format!("{a}; {b}")),
        (a, b) => b.clone().or_else(|| a.clone()),
    };
    let kick_frame = second.kick_frame.map(|k| k + last);
    Some(Clip { kick_frame, license, ..rebuilt(second, model, &all) })
}

/// Labels the leg with the faster foot, and the frame in which it is fastest.
pub fn label(clip: &mut Clip, model: &RobotModel, spec: &RobotSpec) {
    if let Some(kick) = fastest_kick(clip, model, spec) {
        (clip.kick_leg, clip.kick_frame) = (kick.leg, Some(kick.frame));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::MotionLibrary;

    fn kick() -> (RobotModel, RobotSpec, Clip) {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let clip = MotionLibrary::builtin(&model, &spec, 50.0).expect("built in").clips.remove(0);
        (model, spec, clip)
    }

    #[test]
    fn a_cut_keeps_its_frames_and_moves_the_kick() {
        let (model, _, mut clip) = kick();
        clip.kick_frame = Some(60);
        let part = cut(&clip, &model, 0.4, 1.4).expect("long enough");
        assert_eq!((part.frames, part.kick_frame), (51, Some(40)));
        assert_eq!(part.joint_pos(7), clip.joint_pos(27));
        assert!(cut(&clip, &model, 1.0, 1.02).is_none(), "two frames");
    }

    #[test]
    fn times_that_are_negative_or_no_numbers_cut_nothing() {
        let (model, _, clip) = kick();
        let (nan, inf) = (f64::NAN, f64::INFINITY);
        for [from, to] in [[nan, 1.0], [inf, inf], [-0.1, 1.0], [0.0, nan], [0.0, -1.0], [0.0, -inf]] {
            assert!(cut(&clip, &model, from, to).is_none(), "{from} to {to}");
        }
        let rest = cut(&clip, &model, 0.4, inf).expect("to the end");
        assert_eq!(rest.frames, clip.frames - 20);
    }

    #[test]
    fn a_mirrored_kick_is_of_the_other_leg_and_mirrored_twice_itself() {
        let (model, spec, clip) = kick();
        let image = mirror(&clip, &model, &spec).expect("symmetric");
        assert_ne!(image.kick_leg, clip.kick_leg);
        let mut labeled = image.clone();
        label(&mut labeled, &model, &spec);
        assert_eq!(labeled.kick_leg, image.kick_leg, "the faster foot is the other one");
        let [x, y, z] = clip.body_pos(40)[0];
        assert_eq!(image.body_pos(40)[0], [x, -y, z]);
        let again = mirror(&image, &model, &spec).expect("symmetric");
        assert_eq!(again.joint_pos, clip.joint_pos);
    }

    #[test]
    fn a_joined_clip_continues_where_the_first_ended() {
        let (model, spec, clip) = kick();
        let image = mirror(&clip, &model, &spec).expect("symmetric");
        let both = join(&clip, &image, &model).expect("one rate");
        assert_eq!(both.frames, clip.frames + image.frames - 1);
        let last = clip.frames - 1;
        let way = Vec3(both.body_pos(both.frames - 1)[0]) - Vec3(both.body_pos(last)[0]);
        let own = Vec3(image.body_pos(last)[0]) - Vec3(image.body_pos(0)[0]);
        assert!((way.x().hypot(way.y()) - own.x().hypot(own.y())).abs() < 1e-9);
        let slow = Clip { fps: 25.0, ..image };
        assert!(join(&clip, &slow, &model).is_none());
    }
}
