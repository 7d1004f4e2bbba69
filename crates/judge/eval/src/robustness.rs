//! What goes wrong on a real robot, one thing at a time in MuJoCo: pushes, a payload, a weak motor, late targets, a slippery floor.

use std::f64::consts::TAU;
use std::fmt::Write;

use paid_lanes::rng::Rng;
use paid_lanes::stats::mean;
use paid_mujoco::{SceneOptions, WeakJoint};
use paid_plot::{Table, number};
use paid_task::{Disturbance, EnvSample};
use serde::Serialize;

use crate::EvalError;
use crate::engine::EngineChoice;
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::policy::DriverMaker;
use crate::shooting::{CellScore, Grid, ShootingOptions, outcomes_beside, plan};

/// A push comes at least this long after the start, and before the strike `[s]`.
const FROM_START_S: f64 = 0.2;
const BEFORE_STRIKE_S: f64 = 0.1;
/// A push after the strike comes within these times `[s]`.
const AFTER_STRIKE_S: [f64; 2] = [0.1, 1.0];
/// The robot is watched for this long after its kick, but no longer than the time limit `[s]`: a push comes up to a second after it, and a fall takes another.
const WATCHED_S: f64 = 3.0;

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
}

/// All of them, the first one for comparison.
pub const TROUBLES: [Trouble; 11] = [
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
        }
    }

    /// Changes robot, task and scene.
    ///
    /// # Errors
    /// If the robot has no such part, or a control step is too short for the delay.
    fn apply(self, setup: &mut EvalSetup, scene: &mut SceneOptions) -> Result<(), EvalError> {
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
        }
        Ok(())
    }
}

/// Pushes the robot once.
struct Pusher {
    /// Control steps before the push, and the impulse `[N s]`.
    push: Option<(u32, [f64; 3])>,
    step: u32,
}

impl Pusher {
    /// `strike_s`: when the trial's motion strikes; `mass`: of the robot `[kg]`.
    fn new(trouble: Trouble, rng: &mut Rng, strike_s: f64, mass: f64, control_dt_s: f64) -> Self {
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

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessOptions {
    /// Shots at each of the 63 places of the effective workspace.
    pub trials: usize,
    /// Speed range of the balls `[m/s]`; `None` lies still.
    pub rolling: Option<[f64; 2]>,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
}

/// One trouble's score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessRow {
    /// What went wrong.
    pub trouble: Trouble,
    /// In words.
    pub name: String,
    /// Scores.
    pub score: CellScore,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessReport {
    /// What was run.
    pub options: RobustnessOptions,
    /// Scene and knowledge in words, with MuJoCo's version.
    pub title: String,
    /// One row for each trouble.
    pub rows: Vec<RobustnessRow>,
    /// Mean share of goals over the troubles, the first row left out.
    pub mean: Option<f64>,
    /// The least share of goals, and with which trouble.
    pub worst: Option<(f64, String)>,
}

/// Shoots in MuJoCo with each of [`TROUBLES`], whatever the setup's engine; `scene` is the usual one. The shots are the same in all rows. A
/// stopped evaluation has fewer rows.
///
/// # Errors
/// As [`crate::shooting::evaluate`], or if the robot lacks a part that is changed.
pub fn evaluate(
    setup: &EvalSetup,
    scene: &SceneOptions,
    policy: &DriverMaker,
    options: &RobustnessOptions,
) -> Result<RobustnessReport, EvalError> {
    let engine = |scene: SceneOptions| EngineChoice::Mujoco(Box::new(scene));
    let usual = EvalSetup { engine: engine(scene.clone()), ..setup.clone() };
    let facts = usual.engine.facts(&usual.preset);
    let watched_s = WATCHED_S.min(options.limit_s);
    let shots = ShootingOptions {
        grid: Grid::EFFECTIVE,
        trials: options.trials,
        rolling: options.rolling,
        limit_s: options.limit_s,
        after_s: Some(watched_s),
        ..ShootingOptions::default()
    };
    let trials = plan(&usual, &shots)?;
    let (mass, dt_s) = (usual.robot.mass(), usual.preset.control_dt_s());
    let mut rows = Vec::new();
    for trouble in TROUBLES {
        if setup.monitor.stopped() {
            break;
        }
        let (mut scene, mut setup) = (scene.clone(), setup.clone());
        trouble.apply(&mut setup, &mut scene)?;
        setup.engine = engine(scene);
        let pusher = |i: usize| {
            // Every trouble's push comes at the same share of its time, in the same direction.
            let mut rng = Rng::new(setup.seed, i as u32, 0x7055);
            let strike_s = setup.library.facts()[trials[i].motion].times_from(0, dt_s).to_strike_s;
            Pusher::new(trouble, &mut rng, strike_s, mass, dt_s)
        };
        let outcomes = outcomes_beside(&setup, policy, &shots, &trials, pusher, |_| ())?;
        let outcomes: Vec<_> = outcomes.iter().map(|(outcome, ())| outcome).collect();
        if !outcomes.is_empty() {
            rows.push(RobustnessRow { trouble, name: trouble.name(), score: CellScore::of(None, &outcomes) });
        }
    }
    let title = format!(
        "{}; one thing goes wrong at a time; effective workspace, {} {} balls per place, robot displaced by up to 0.5 m and watched for \
         {watched_s} s after the kick{}",
        facts.name,
        options.trials,
        if options.rolling.is_some() { "rolling" } else { "static" },
        facts.knowledge_text()
    );
    Ok(RobustnessReport::new(options.clone(), title, rows))
}

/// Titles of the table and of the CSV.
const COLUMNS: [&str; 6] = ["what goes wrong", "trials", "success", "accuracy", "contact", "falls"];

impl RobustnessRow {
    fn cells(&self) -> [String; 6] {
        let share = |share: f64| format!("{:.1}%", 100.0 * share);
        let s = &self.score;
        [
            self.name.clone(),
            s.success.trials.to_string(),
            share(s.success.share),
            s.accuracy.map_or("-".to_owned(), |v| number(v, 3)),
            share(s.contact.share),
            share(s.falls_ever.share),
        ]
    }
}

impl RobustnessReport {
    fn new(options: RobustnessOptions, title: String, rows: Vec<RobustnessRow>) -> Self {
        let wrong = || rows.iter().filter(|row| row.trouble != Trouble::None);
        let goals = |row: &RobustnessRow| row.score.success.share;
        let worst = wrong().min_by(|a, b| goals(a).total_cmp(&goals(b)));
        Self {
            options,
            title,
            mean: mean(wrong().map(goals)),
            worst: worst.map(|row| (goals(row), row.name.clone())),
            rows,
        }
    }

    /// The rows, mean and worst as text. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let mut out = format!("{}\n\n", self.title);
        let mut table = Table::new(&COLUMNS);
        self.rows.iter().for_each(|row| table.row(row.cells()));
        let _ = write!(out, "{table}");
        if let (Some(mean), Some((worst, name))) = (self.mean, &self.worst) {
            let _ = writeln!(out, "mean {:.1}%, worst {:.1}% ({name})", 100.0 * mean, 100.0 * worst);
        }
        out
    }

    /// One line per trouble.
    pub fn csv(&self) -> String {
        let mut out = format!("{}\n", COLUMNS.join(","));
        for row in &self.rows {
            let _ = writeln!(out, "{}", row.cells().join(","));
        }
        out
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
    fn the_worst_is_named_and_nothing_wrong_does_not_count() {
        let row = |trouble: Trouble, goals: &[bool]| {
            let mut score = CellScore::of(None, &[]);
            score.success = crate::metrics::statistics::Share::of(goals.iter().copied());
            RobustnessRow { trouble, name: trouble.name(), score }
        };
        let rows = vec![
            row(Trouble::None, &[false, false]),
            row(Trouble::Late(0.02), &[true, false]),
            row(Trouble::WeakKnee(1, 0.8), &[true, true]),
        ];
        let options = RobustnessOptions { trials: 1, rolling: None, limit_s: 12.0 };
        let report = RobustnessReport::new(options, "title".into(), rows);
        assert_eq!(report.mean, Some(0.75));
        assert!(
            report.table().ends_with("mean 75.0%, worst 50.0% (targets 20 ms later)\n"),
            "{}",
            report.table()
        );
        assert!(report.csv().contains("\nright knee with 80% of its torque,2,100.0%,"), "{}", report.csv());
    }

    #[test]
    fn names_stand_in_a_csv_and_differ() {
        let names: Vec<String> = TROUBLES.into_iter().map(Trouble::name).collect();
        for (i, name) in names.iter().enumerate() {
            assert!(!name.contains(',') && !names[..i].contains(name), "{name}");
        }
    }
}
