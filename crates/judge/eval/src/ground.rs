//! The grounds that an evaluation can be played on, by name.

use std::str::FromStr;

use paid_mujoco::{Ground as Shape, SceneOptions};
use paid_task::TaskPreset;
use serde::{Deserialize, Serialize};

use crate::panel::TURF;
use crate::{EvalError, Setting};

/// Time constant of contacts with turf `[s]`. A G1 that is set down at its nominal height sinks in by 4.5 mm and then stands 0.6 mm deep; with
/// the usual 10 ms 1.3 and 0.1 mm.
const SOFT_S: f64 = 0.04;
/// The same of a hard floor `[s]`: the shortest that MuJoCo resolves in its steps of 2 ms.
const HARD_S: f64 = 0.004;

/// A ground in MuJoCo.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Ground {
    /// z = 0, with the scene's own surface.
    #[default]
    Flat,
    /// Heights of minus 1 cm, 0 and 1 cm at random, 10 cm apart; others in each trial.
    #[serde(rename = "rough-1cm")]
    Rough1Cm,
    /// The same with 2 cm, as in Stage I.
    #[serde(rename = "rough-2cm")]
    Rough2Cm,
    /// The same with 3 cm.
    #[serde(rename = "rough-3cm")]
    Rough3Cm,
    /// A plane that falls by 2 degrees, in each trial in another direction.
    #[serde(rename = "slope-2deg")]
    Slope2Deg,
    /// The same by 4 degrees.
    #[serde(rename = "slope-4deg")]
    Slope4Deg,
    /// Flat, soft, and slows the ball as grass does.
    Turf,
    /// Flat and hard.
    Hard,
}

impl Ground {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Flat,
        Self::Rough1Cm,
        Self::Rough2Cm,
        Self::Rough3Cm,
        Self::Slope2Deg,
        Self::Slope4Deg,
        Self::Turf,
        Self::Hard,
    ];

    /// The name that a user writes.
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Rough1Cm => "rough-1cm",
            Self::Rough2Cm => "rough-2cm",
            Self::Rough3Cm => "rough-3cm",
            Self::Slope2Deg => "slope-2deg",
            Self::Slope4Deg => "slope-4deg",
            Self::Turf => "turf",
            Self::Hard => "hard",
        }
    }

    /// Changes the ground of a scene; on turf the ball of scene and task too.
    pub fn apply(self, scene: &mut SceneOptions, task: &mut TaskPreset) {
        let rough = |amplitude_m| Shape::Rough { amplitude_m, seed: 0 };
        let slope = |degrees: f64| Shape::Slope { angle_rad: degrees.to_radians(), downhill_rad: 0.0 };
        match self {
            Self::Flat => {}
            Self::Rough1Cm => scene.ground = rough(0.01),
            Self::Rough2Cm => scene.ground = rough(0.02),
            Self::Rough3Cm => scene.ground = rough(0.03),
            Self::Slope2Deg => scene.ground = slope(2.0),
            Self::Slope4Deg => scene.ground = slope(4.0),
            Self::Turf => {
                [task.ball_params.linear_damping, task.ball_params.angular_damping] = TURF.damping;
                if let Some(ball) = &mut scene.ball {
                    ball.params = task.ball_params;
                    ball.friction[0] = TURF.friction;
                    ball.damped = true;
                }
                scene.floor.friction[0] = TURF.floor_friction;
                scene.floor.solref[0] = SOFT_S;
            }
            Self::Hard => scene.floor.solref[0] = HARD_S,
        }
    }
}

impl FromStr for Ground {
    type Err = EvalError;

    fn from_str(text: &str) -> Result<Self, EvalError> {
        let found = Self::ALL.into_iter().find(|ground| ground.name() == text);
        found.ok_or_else(|| EvalError::Option {
            option: Setting::Named("ground"),
            expected: Self::ALL.map(Self::name).join(", "),
            found: format!("'{text}'"),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_scene_files_and_another_one_is_refused() {
        for ground in Ground::ALL {
            assert_eq!(ground.name().parse::<Ground>().expect("its own name"), ground);
            let json = serde_json::to_string(&ground).expect("a word");
            assert_eq!(json, format!("\"{}\"", ground.name()));
        }
        let error = "ice".parse::<Ground>().expect_err("no such ground").to_string();
        assert!(error.starts_with("ground: expected flat, rough-1cm, "), "{error}");
        assert!(error.ends_with("turf, hard, found 'ice'"), "{error}");
    }

    #[test]
    fn flat_ground_changes_nothing_and_all_others_differ() {
        let scenes = Ground::ALL.map(|ground| {
            let mut task = TaskPreset::builtin("paper_stage2").expect("built in");
            let mut scene = SceneOptions::default();
            ground.apply(&mut scene, &mut task);
            assert_eq!(ground == Ground::Turf, scene.ball != SceneOptions::default().ball);
            scene
        });
        assert_eq!(scenes[0], SceneOptions::default());
        for (i, scene) in scenes.iter().enumerate() {
            assert!(!scenes[..i].contains(scene), "{i}");
        }
    }
}
