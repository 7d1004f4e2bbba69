//! Whether a clip can be a motion of this robot: on its feet, in meters and radians, with z up, at its frame rate.

use core::fmt;

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, RobotSpec};

use crate::Clip;

/// A foot that is faster is no robot's `[m/s]`: the fastest kicks reach some 15.
const FASTEST_FOOT: f64 = 60.0;
/// So far beyond its range a joint's angle is in another unit `[rad]`.
const BEYOND_RANGE: f64 = core::f64::consts::PI;

/// Why a clip cannot be a motion of the robot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Implausible {
    /// A joint is far beyond its range.
    Angle {
        /// The joint.
        joint: String,
        /// Its range `[rad]`.
        range: [f64; 2],
        /// The angle farthest from zero.
        found: f64,
        /// True if all angles are within their ranges as degrees.
        degrees: bool,
    },
    /// A foot is faster than any robot's.
    Speed {
        /// Its speed `[m/s]`.
        found: f64,
        /// In which frame.
        frame: usize,
    },
    /// The base is not where a stand has it.
    Height {
        /// The robot's standing height `[m]`.
        expected: f64,
        /// Median height of the base.
        found: f64,
        /// What it looks like: empty, or a colon and a few words.
        hint: &'static str,
    },
    /// The base is tilted by more than 60 degrees in most frames.
    Lies {
        /// In how many `[%]`.
        share: f64,
    },
}

impl Implausible {
    /// What is wrong with a clip; `None` if it may be a motion of the robot.
    pub fn of(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Option<Self> {
        Self::angle(clip, model).or_else(|| Self::pose(clip, spec)).or_else(|| Self::speed(clip, model, spec))
    }

    fn angle(clip: &Clip, model: &RobotModel) -> Option<Self> {
        let beyond = |unit: f64| {
            let over = move |(k, q): (usize, &f64)| {
                let (j, q) = (k % clip.joints.max(1), q * unit);
                let [lo, hi] = model.joints[j].range;
                ((lo - q).max(q - hi), j, q)
            };
            clip.joint_pos.iter().enumerate().map(over).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let (excess, j, found) = beyond(1.0)?;
        let degrees = beyond(1.0_f64.to_radians()).is_some_and(|(excess, ..)| excess < 0.2);
        let joint = &model.joints[j];
        (excess > BEYOND_RANGE).then(|| Self::Angle {
            joint: joint.name.clone(),
            range: joint.range,
            found,
            degrees,
        })
    }

    fn speed(clip: &Clip, model: &RobotModel, spec: &RobotSpec) -> Option<Self> {
        let feet = spec.indices(model).ok()?.feet;
        let speed = |t: usize| {
            feet.map(|foot| Vec3(clip.body_lin_vel(t)[foot]).norm()).into_iter().fold(0.0, f64::max)
        };
        let (found, frame) = (0..clip.frames).map(|t| (speed(t), t)).max_by(|a, b| a.0.total_cmp(&b.0))?;
        (found > FASTEST_FOOT).then_some(Self::Speed { found, frame })
    }

    fn pose(clip: &Clip, spec: &RobotSpec) -> Option<Self> {
        let mut heights: Vec<f64> = (0..clip.frames).map(|t| clip.body_pos(t)[0][2]).collect();
        heights.sort_by(f64::total_cmp);
        let (found, expected) = (heights.get(heights.len() / 2).copied()?, spec.nominal_height_m);
        let share = found / expected;
        let lies = |t: &usize| Quat(clip.body_quat(*t)[0]).rotate(Vec3([0.0, 0.0, 1.0])).z() < 0.5;
        let lying = (0..clip.frames).filter(lies).count() as f64 / clip.frames as f64;
        let hint = match share {
            s if (30.0..300.0).contains(&s) => ": these look like centimeters",
            s if (300.0..3000.0).contains(&s) => ": these look like millimeters",
            s if s > 2.0 => ": it floats, or the unit of length is another",
            s if (0.003..0.03).contains(&s) => ": meters divided by 100?",
            _ => "",
        };
        // With another axis up the height is nothing but a place on the floor.
        if lying > 0.5 && share.abs() < 30.0 {
            return Some(Self::Lies { share: 100.0 * lying });
        }
        if !hint.is_empty() {
            return Some(Self::Height { expected, found, hint });
        }
        (share < 0.4).then_some(Self::Height { expected, found, hint: ": it does not stand" })
    }
}

impl fmt::Display for Implausible {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angle { joint, range: [lo, hi], found, degrees } => {
                let hint = if *degrees { ": these look like degrees" } else { "" };
                write!(f, "expected {joint} from {lo:.2} to {hi:.2} rad, found {found:.2}{hint}")
            }
            Self::Speed { found, frame } => write!(
                f,
                "expected feet slower than {FASTEST_FOOT} m/s, found {found:.0} in frame {frame}: the frame rate may be another, or a joint jumps"
            ),
            Self::Height { expected, found, hint } => {
                write!(f, "expected a base about {expected:.2} m above the floor, found {found:.2}{hint}")
            }
            Self::Lies { share } => write!(
                f,
                "expected a robot that stands, found its base more than 60 degrees off upright in {share:.0} % of the frames: \
                 it lies, or another axis points up"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::{Look, generate_builtin};

    fn said(change: impl FnOnce(&mut Clip)) -> String {
        let (model, spec) = (RobotModel::g1(), RobotSpec::g1());
        let mut clip = generate_builtin(&model, &spec, Look::default()).expect("kicks").swap_remove(0).clip;
        change(&mut clip);
        Implausible::of(&clip, &model, &spec).map_or_else(String::new, |what| what.to_string())
    }

    #[test]
    fn degrees_and_impossible_feet_are_called_what_they_are() {
        assert_eq!(said(|_| ()), "");
        let degrees = said(|clip| clip.joint_pos.iter_mut().for_each(|q| *q = q.to_degrees()));
        assert!(
            degrees.starts_with("expected ") && degrees.ends_with(": these look like degrees"),
            "{degrees}"
        );
        let wild = said(|clip| clip.joint_pos[7] = 1000.0);
        assert!(wild.contains("found 1000.00") && !wild.contains("degrees"), "{wild}");
        let fast = said(|clip| clip.body_lin_vel.iter_mut().for_each(|v| *v = v.map(|x| 100.0 * x)));
        assert!(fast.contains("feet slower than 60 m/s") && fast.contains("frame rate"), "{fast}");
    }
}
