//! What goes wrong, one thing at a time.

use std::f64::consts::TAU;

use paid_lanes::rng::Rng;
use paid_mujoco::{SceneOptions, WeakJoint};
use paid_task::{Disturbance, EnvSample};
use serde::Serialize;

use crate::EvalError;
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::ground::Ground;

/// A push comes at least this long after the start, and before the strike `[s]`.
const FROM_START_S: f64 = 0.2;
const BEFORE_STRIKE_S: f64 = 0.1;
/// A push after the strike comes within these times `[s]`.
const AFTER_STRIKE_S: [f64; 2] = [0.1, 1.0];

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Trouble {
    /// Nothing.
    None,
    /// At a random moment the robot's velocity changes by this in a random horizontal direction `[m/s]`.
    Push {
        /// Change of velocity `[m/s]`.
        speed: f64,
        /// Before the strike, or within a second after it.
        before_strike: bool,
    },
    /// A mass in the torso, at its center of mass `[kg]`.
    Payload(f64),
    /// One knee has this share of its torque; 0 is the left knee, 1 the right one.
    WeakKnee(usize, f64),
    /// Targets reach the motors this much later `[s]`.
    Late(f64),
    /// Sliding friction between feet and floor.
    Floor(f64),
    /// Another ground.
    Ground(Ground),
}

/// Which of them are played, the first one for comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Series {
    /// Nothing, pushes, a payload, a weak knee, late targets, a slippery floor.
    Robustness,
    /// Every [`Ground`].
    Terrain,
}

/// What can go wrong on any ground.
const TROUBLES: [Trouble; 11] = [
    Trouble::None,
    Trouble::Push { speed: 0.5, before_strike: true },
    Trouble::Push { speed: 0.5, before_strike: false },
    Trouble::Push { speed: 1.0, before_strike: true },
    Trouble::Push { speed: 1.0, before_strike: false },
    Trouble::Payload(1.0),
    Trouble::Payload(2.0),
    Trouble::WeakKnee(0, 0.8),
    Trouble::WeakKnee(1, 0.8),
    Trouble::Late(0.02),
    Trouble::Floor(0.4),
];

impl Series {
    /// Its rows.
    pub fn troubles(self) -> Vec<Trouble> {
        match self {
            Self::Robustness => TROUBLES.to_vec(),
            Self::Terrain => Ground::ALL.map(Trouble::Ground).to_vec(),
        }
    }

    /// In one word.
    pub fn name(self) -> &'static str {
        match self {
            Self::Robustness => "robustness",
            Self::Terrain => "terrain",
        }
    }

    /// The title of the rows' names.
    pub(super) fn column(self) -> &'static str {
        match self {
            Self::Robustness => "what goes wrong",
            Self::Terrain => "ground",
        }
    }

    /// What differs between the rows, in a report's title.
    pub(super) fn says(self) -> &'static str {
        match self {
            Self::Robustness => "one thing goes wrong at a time",
            Self::Terrain => "one ground after the other",
        }
    }
}

impl Trouble {
    /// In words.
    pub fn name(self) -> String {
        match self {
            Self::None => "nothing".to_owned(),
            Self::Push { speed, before_strike } => {
                let when = if before_strike { "before" } else { "after" };
                format!("push of {speed:.1} m/s {when} the strike")
            }
            Self::Payload(mass) => format!("{mass:.0} kg more in the torso"),
            Self::WeakKnee(side, share) => {
                format!("{} knee with {:.0}% of its torque", ["left", "right"][side], 100.0 * share)
            }
            Self::Late(delay) => format!("targets {:.0} ms later", 1e3 * delay),
            Self::Floor(friction) => format!("floor friction {friction:.1}"),
            Self::Ground(ground) => ground.name().to_owned(),
        }
    }

    /// True for the row that the others are compared with.
    pub fn is_usual(self) -> bool {
        matches!(self, Self::None | Self::Ground(Ground::Flat))
    }

    /// Changes robot, task and scene.
    ///
    /// # Errors
    /// If the robot has no such part, or a control step is too short for the delay.
    pub(super) fn apply(self, setup: &mut EvalSetup, scene: &mut SceneOptions) -> Result<(), EvalError> {
        let missing = |what: &str, name: &str| EvalError::Option {
            option: crate::Setting::Named("robot"),
            expected: format!("{what} '{name}', which the evaluation changes"),
            found: "none".to_owned(),
        };
        match self {
            Self::None | Self::Push { .. } => {}
            Self::Payload(mass) => {
                let name = &setup.spec.anchor_body;
                let body = setup.robot.body_index(name).ok_or_else(|| missing("a body", name))?;
                setup.robot.bodies[body].mass += mass;
            }
            Self::WeakKnee(side, share) => {
                let name = ["left_knee_joint", "right_knee_joint"][side];
                if !setup.robot.joints.iter().any(|joint| joint.name == name) {
                    return Err(missing("a joint", name));
                }
                // In the scene alone: the policy's action scale and its mirror image are those of the robot that it knows.
                scene.weak_joint = Some(WeakJoint { name: name.to_owned(), share });
            }
            Self::Late(delay_s) => setup.preset.action_delay_s += delay_s,
            Self::Floor(friction) => {
                scene.floor.friction[0] = friction;
                scene.resolve_contacts();
            }
            Self::Ground(ground) => {
                ground.apply(scene, &mut setup.preset);
                scene.resolve_contacts();
            }
        }
        Ok(())
    }
}

/// Pushes the robot once.
pub(super) struct Pusher {
    /// Control steps before the push, and the impulse `[N s]`.
    push: Option<(u32, [f64; 3])>,
    step: u32,
}

impl Pusher {
    /// `strike_s`: when the trial's motion strikes; `mass`: of the robot `[kg]`.
    pub(super) fn new(trouble: Trouble, rng: &mut Rng, strike_s: f64, mass: f64, control_dt_s: f64) -> Self {
        let push = match trouble {
            Trouble::Push { speed, before_strike } => {
                let [from, to] = if before_strike {
                    [FROM_START_S, (strike_s - BEFORE_STRIKE_S).max(FROM_START_S)]
                } else {
                    AFTER_STRIKE_S.map(|s| strike_s + s)
                };
                let steps = (rng.uniform(from, to) / control_dt_s).round() as u32;
                let (y, x) = rng.uniform(0.0, TAU).sin_cos();
                Some((steps, [x * speed * mass, y * speed * mass, 0.0]))
            }
            _ => None,
        };
        Self { push, step: 0 }
    }
}

impl Observer for Pusher {
    fn observe(&mut self, sample: &EnvSample, _ended: Option<Ending>) -> bool {
        self.step = sample.step;
        false
    }
    fn disturbance(&mut self) -> Option<Disturbance> {
        self.push.filter(|(step, _)| *step == self.step).map(|(_, impulse)| Disturbance::Push(impulse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_push_comes_once_within_its_time() {
        for before_strike in [true, false] {
            let trouble = Trouble::Push { speed: 0.5, before_strike };
            let mut steps = Vec::new();
            for trial in 0..200 {
                let pusher = Pusher::new(trouble, &mut Rng::new(1, trial, 0), 2.0, 30.0, 0.02);
                let (step, [x, y, z]) = pusher.push.expect("a push");
                // 0.5 m/s of 30 kg.
                assert!((x.hypot(y) - 15.0).abs() < 1e-9 && z == 0.0, "{x} {y} {z}");
                steps.push(step);
            }
            let range = (*steps.iter().min().expect("some"), *steps.iter().max().expect("some"));
            // From 0.2 s on, until 0.1 s before the strike; or 0.1 to 1 s after it.
            let [from, to] = if before_strike { [10, 95] } else { [105, 150] };
            assert!(range.0 >= from && range.0 < from + 3 && range.1 <= to && range.1 > to - 3, "{range:?}");
        }
    }

    #[test]
    fn the_pusher_pushes_in_its_step_alone() {
        let mut pusher = Pusher { push: Some((7, [1.0, 2.0, 0.0])), step: 0 };
        let mut pushed = Vec::new();
        for step in 0..10 {
            pusher.step = step;
            pushed.extend(pusher.disturbance().map(|push| (step, push)));
        }
        assert_eq!(pushed, [(7, Disturbance::Push([1.0, 2.0, 0.0]))]);
        assert!(Pusher::new(Trouble::Payload(1.0), &mut Rng::new(1, 0, 0), 2.0, 30.0, 0.02).push.is_none());
    }

    #[test]
    fn names_stand_in_a_csv_and_differ() {
        let names: Vec<String> = [Series::Robustness, Series::Terrain]
            .map(Series::troubles)
            .concat()
            .into_iter()
            .map(Trouble::name)
            .collect();
        for (i, name) in names.iter().enumerate() {
            assert!(!name.contains(',') && !names[..i].contains(name), "{name}");
        }
    }
}
