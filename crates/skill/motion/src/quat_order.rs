//! The order of a quaternion's numbers in files that do not state it.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec};

use crate::Clip;
use crate::implausible::Implausible;
use crate::poses::Base;

/// Order of a quaternion's four numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuatOrder {
    /// x, y, z, w: Unitree's, BeyondMimic's and GMR's files.
    Xyzw,
    /// w, x, y, z: MuJoCo and Isaac Lab.
    Wxyz,
}

impl std::str::FromStr for QuatOrder {
    type Err = String;

    /// Accepts `xyzw` and `wxyz`.
    fn from_str(name: &str) -> Result<Self, String> {
        match name {
            "xyzw" => Ok(Self::Xyzw),
            "wxyz" => Ok(Self::Wxyz),
            other => Err(format!("expected 'xyzw' or 'wxyz', found '{other}'")),
        }
    }
}

impl QuatOrder {
    /// The quaternion w, x, y, z of four numbers in this order.
    pub(crate) fn quat(self, q: [f64; 4]) -> [f64; 4] {
        match self {
            Self::Xyzw => [q[3], q[0], q[1], q[2]],
            Self::Wxyz => q,
        }
    }
}

/// A reading as wrong as this is doubted at all: mean tilt of the base `[rad]` plus mean speed of the slower foot `[m/s]`.
const DOUBTFUL: f64 = 0.3;
/// The other reading must be this much better.
const CLEARLY: f64 = 0.5;

/// True if the robot of a clip, whose quaternions were read in the order x, y, z, w, moves like one on its feet only in the other order: it
/// is upright there, and one of its feet stays where it is. A robot that faces backward is upright in both.
pub(crate) fn stands_in_the_other_order(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> bool {
    let Ok(feet) = spec.indices(model).map(|indices| indices.feet) else { return false };
    let swapped: Vec<Base> = (0..clip.frames)
        .map(|t| {
            let [w, x, y, z] = clip.body_quat(t)[0];
            (clip.body_pos(t)[0], QuatOrder::Wxyz.quat([x, y, z, w]))
        })
        .collect();
    let other = Clip::from_poses(model, clip.fps, &swapped, &clip.joint_pos);
    let (here, there) = (oddness(clip, feet), oddness(&other, feet));
    here > DOUBTFUL && there < CLEARLY * here && Implausible::of(&other, model, spec).is_none()
}

/// Mean tilt of the base `[rad]` plus mean speed of the slower foot `[m/s]`: small for a robot that walks, stands or kicks.
fn oddness(clip: &Clip, feet: [usize; 2]) -> f64 {
    let tilt =
        |t: usize| Quat(clip.body_quat(t)[0]).rotate(Vec3([0.0, 0.0, 1.0])).z().clamp(-1.0, 1.0).acos();
    let speed = |t: usize, foot: usize| {
        (Vec3(clip.body_pos(t + 1)[foot]) - Vec3(clip.body_pos(t)[foot])).norm() * clip.fps
    };
    let slower = |t: usize| speed(t, feet[0]).min(speed(t, feet[1]));
    let mean = |sum: f64, n: usize| sum / n.max(1) as f64;
    let last = clip.frames.saturating_sub(1);
    mean((0..clip.frames).map(tilt).sum(), clip.frames) + mean((0..last).map(slower).sum(), last)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Look, generate_builtin};
    use crate::{ReadOptions, parse_csv};

    /// A CSV motion without names and comments, the whole clip turned by `heading` rad about z.
    fn text(clip: &Clip, order: QuatOrder, heading: f64) -> String {
        let turn = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), heading);
        let row = |t: usize| {
            let [w, x, y, z] = turn.mul(Quat(clip.body_quat(t)[0])).0;
            let quat = if order == QuatOrder::Xyzw { [x, y, z, w] } else { [w, x, y, z] };
            let numbers = turn.rotate(Vec3(clip.body_pos(t)[0])).0.into_iter().chain(quat);
            let fields: Vec<String> =
                numbers.chain(clip.joint_pos(t).iter().copied()).map(|x| x.to_string()).collect();
            fields.join(",") + "\n"
        };
        (0..clip.frames).map(row).collect()
    }

    #[test]
    fn the_order_shows_in_how_the_robot_stands_whichever_way_it_faces() {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let kicks = generate_builtin(&model, &spec, Look::default()).expect("kicks");
        let read = |text: &str, quat| {
            let options = ReadOptions { fps: Some(50.0), quat, ..ReadOptions::default() };
            parse_csv(text, "kick.csv".as_ref(), &model, &spec, &options)
        };
        for kick in kicks.iter().step_by(3) {
            for heading in [0.0, 1.6, 2.6, std::f64::consts::PI, -0.7] {
                let (right, wrong) =
                    (text(&kick.clip, QuatOrder::Xyzw, heading), text(&kick.clip, QuatOrder::Wxyz, heading));
                let clip = read(&right, None)
                    .unwrap_or_else(|error| panic!("{} at {heading}: {error}", kick.clip.name));
                let error = read(&wrong, None).expect_err("the other order").to_string();
                assert!(error.contains("--quat wxyz"), "{} at {heading}: {error}", kick.clip.name);
                let given = read(&wrong, Some(QuatOrder::Wxyz)).expect("the order is given");
                let same = |other: &Clip| {
                    let pairs = other.body_quat.as_flattened().iter().zip(clip.body_quat.as_flattened());
                    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) < 1e-12
                };
                assert!(same(&given));
                assert!(same(&read(&format!("# quat: wxyz\n{wrong}"), None).expect("stated")));
                read(&wrong, Some(QuatOrder::Xyzw)).expect("as the user says");
            }
        }
    }
}
