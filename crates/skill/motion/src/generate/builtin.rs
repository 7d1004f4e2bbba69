//! The kicks that the program brings along.

use paid_robot::{RobotModel, RobotSpec};

use super::{GenerateError, GeneratedKick, KickRequest, KickStyle, generate_kick};
use crate::KickLeg;

/// Terms of generated clips: the project's own.
pub const BUILTIN_LICENSE: &str = "MIT OR Apache-2.0";

/// Distances of the two rings of balls `[m]` and the angle between neighbors on each [degrees]: about 30 cm along a ring,
/// as in the paper's recordings.
const RINGS: [(f64, f64); 2] = [(0.85, 20.0), (1.20, 14.0)];
/// Angles of the powerful kicks `[degrees]` and their distance `[m]`.
const POWERFUL: ([f64; 3], f64) = ([0.0, 9.0, -9.0], 1.35);

/// A kick of the library and the set that it belongs to.
#[derive(Clone, Debug, PartialEq)]
pub struct BuiltinKick {
    /// `standard` or `powerful`.
    pub set: &'static str,
    /// What to make.
    pub request: KickRequest,
}

/// How the kicks of the library look.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Look {
    /// What `policies/demo` was trained on.
    #[default]
    Plain,
    /// Moved more as people do ([`KickStyle::natural`]).
    Natural,
}

impl Look {
    fn styles(self) -> [KickStyle; 2] {
        match self {
            Self::Plain => [KickStyle::standard(), KickStyle::powerful()],
            Self::Natural => [KickStyle::natural(), KickStyle::natural_powerful()],
        }
    }
}

/// The kicks of [`builtin_kicks_of`] that a program without motion files trains on.
pub fn builtin_kicks() -> Vec<BuiltinKick> {
    builtin_kicks_of(Look::default())
}

/// Ten standard kicks, five balls on each of two rings, and three powerful ones. Balls on the left are for the left foot, those
/// on the right for the right; straight ahead the near ring has the right foot and the far ring the left.
pub fn builtin_kicks_of(look: Look) -> Vec<BuiltinKick> {
    let [standard, powerful] = look.styles();
    let mut kicks = Vec::new();
    let mut add = |set: &'static str, radius: f64, degrees: f64, middle: KickLeg, style: KickStyle| {
        let number = kicks.iter().filter(|k: &&BuiltinKick| k.set == set).count() + 1;
        let leg = match degrees {
            d if d > 0.0 => KickLeg::Left,
            d if d < 0.0 => KickLeg::Right,
            _ => middle,
        };
        let (s, c) = degrees.to_radians().sin_cos();
        let request = KickRequest {
            name: format!("{set}_{number:02}_{leg}"),
            ball: [radius * c, radius * s],
            leg,
            style,
        };
        kicks.push(BuiltinKick { set, request });
    };
    for ((radius, step), middle) in RINGS.into_iter().zip([KickLeg::Right, KickLeg::Left]) {
        for place in [0.0, 1.0, 2.0, -1.0, -2.0] {
            add("standard", radius, place * step, middle, standard);
        }
    }
    let (angles, radius) = POWERFUL;
    for degrees in angles {
        add("powerful", radius, degrees, KickLeg::Right, powerful);
    }
    kicks
}

/// Makes the whole library, in the order of [`builtin_kicks_of`], each clip's path being `built-in/SET/NAME.npz` (no such file
/// exists).
///
/// # Errors
/// As [`generate_kick`].
pub fn generate_builtin(
    model: &RobotModel,
    spec: &RobotSpec,
    look: Look,
) -> Result<Vec<GeneratedKick>, GenerateError> {
    let kicks = builtin_kicks_of(look);
    let make = |kick: &BuiltinKick| {
        let mut made = generate_kick(model, spec, &kick.request)?;
        made.clip.path = format!("built-in/{}/{}.npz", kick.set, kick.request.name).into();
        Ok(made)
    };
    // Every kick by itself, on as many threads as there are cores; the result does not depend on how many.
    let threads = std::thread::available_parallelism().map_or(1, usize::from).min(kicks.len());
    let share = kicks.len().div_ceil(threads);
    std::thread::scope(|scope| {
        let workers: Vec<_> = kicks
            .chunks(share)
            .map(|part| scope.spawn(move || part.iter().map(make).collect::<Vec<_>>()))
            .collect();
        workers
            .into_iter()
            .flat_map(|worker| match worker.join() {
                Ok(made) => made,
                Err(panic) => std::panic::resume_unwind(panic),
            })
            .collect()
    })
}
