//! Whether a clip is of a robot on its feet, in meters, with z up.

use core::fmt;

use paid_lanes::{Quat, Vec3};
use paid_robot::RobotSpec;

use crate::Clip;

/// Why a clip cannot be of a robot on its feet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NotUpright {
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

impl NotUpright {
    /// What is wrong with a clip; `None` if it may be of a robot on its feet.
    pub fn of(clip: &Clip, spec: &RobotSpec) -> Option<Self> {
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

impl fmt::Display for NotUpright {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
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
