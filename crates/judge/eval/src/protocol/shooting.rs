//! Shooting at a goal from a grid of ball places (paper, section IV-B).

mod figures;
mod grid;
mod observer;
mod report;
mod score;

use paid_task::{EpisodeRules, InitialState, TimeLimit};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use crate::episodes::{Beside, EvalSetup, Observer, run_episodes};
use crate::policy::DriverMaker;
use crate::share::run_shared;
use crate::trace::{Trace, Traced};
use crate::{EvalError, Setting};

pub(crate) use observer::Watch;

pub use figures::{PAPER, panels, summary};
pub use grid::{Placement, Trial, plan, robot_distance};
pub use report::ShootingReport;
pub use score::{CellScore, Outcome, totals};
#[cfg(test)]
pub(crate) use {observer::tests as observer_tests, report::tests as report_tests};

/// Ball positions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// First and last place ahead of the robot `[m]`.
    pub x: [f64; 2],
    /// First and last place to the left `[m]`.
    pub y: [f64; 2],
    /// Distance between places `[m]`.
    pub step: f64,
}

impl Grid {
    /// The paper's effective workspace.
    pub const EFFECTIVE: Self = Self { x: [0.5, 2.0], y: [-1.0, 1.0], step: 0.25 };
    /// The paper's whole grid of 11 x 13 places.
    pub const WHOLE: Self = Self { x: [0.5, 3.0], y: [-1.5, 1.5], step: 0.25 };

    /// Places along an axis, both ends included.
    pub fn places(&self, axis: [f64; 2]) -> Vec<f64> {
        let n = ((axis[1] - axis[0]) / self.step + 1e-6).floor() as usize;
        (0..=n).map(|i| axis[0] + i as f64 * self.step).collect()
    }
}

/// What the ball place is measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Variant {
    /// The robot's displaced first pose, as in the public evaluation: the displacement then changes nothing.
    Robot,
    /// The undisplaced first pose: the robot stands up to the displacement away from where ball and goal expect it.
    World,
}

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ShootingOptions {
    /// Ball places.
    pub grid: Grid,
    /// Trials per place.
    pub trials: usize,
    /// What ball places are measured from.
    pub variant: Variant,
    /// Radius of the disc of robot displacements `[m]`.
    pub start_radius_m: f64,
    /// Half-width of the uniform offset of a ball from its place, in x and in y `[m]`; half of the grid's step covers the
    /// workspace evenly with random places.
    pub scatter_m: f64,
    /// Speed range of a rolling ball `[m/s]` in any direction; `None`: the ball lies still.
    pub rolling: Option<[f64; 2]>,
    /// Distance of the goal ahead of the robot's first pose `[m]`.
    pub goal_distance_m: f64,
    /// Half of the goal's width `[m]`.
    pub goal_half_width_m: f64,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
    /// For how long after the kick the robot is watched, with the clip's last frame held `[s]`; `None`: until the shot is decided and the
    /// clip has ended, which holds in any case. It is added to the time limit.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub after_s: Option<f64>,
}

impl Default for ShootingOptions {
    /// The paper's static protocol.
    fn default() -> Self {
        Self {
            grid: Grid::WHOLE,
            trials: 50,
            variant: Variant::World,
            start_radius_m: 0.5,
            scatter_m: 0.0,
            rolling: None,
            goal_distance_m: 5.0,
            goal_half_width_m: 1.0,
            limit_s: 12.0,
            after_s: None,
        }
    }
}

/// The rolling protocol's speeds `[m/s]`.
pub const ROLLING_SPEED: [f64; 2] = [0.1, 0.3];

impl ShootingOptions {
    fn check(&self) -> Result<(), EvalError> {
        let bad = |option, expected: &str, found: String| {
            Err(EvalError::Option { option, expected: expected.to_owned(), found })
        };
        let g = &self.grid;
        if !(g.step > 0.0 && g.x[0] <= g.x[1] && g.y[0] <= g.y[1] && (g.x[1] - g.x[0]).is_finite()) {
            return bad(Setting::Named("grid"), "ascending ends and a positive step", format!("{g:?}"));
        }
        if self.trials == 0 {
            return bad(Setting::Trials, "at least 1", "0".into());
        }
        if !(0.0..=2.0).contains(&self.start_radius_m) {
            return bad(Setting::StartRadius, "0 to 2 m", self.start_radius_m.to_string());
        }
        if !(0.0..=1.0).contains(&self.scatter_m) {
            return bad(Setting::Scatter, "0 to 1 m", self.scatter_m.to_string());
        }
        if let Some([lo, hi]) = self.rolling
            && !(0.0 <= lo && lo <= hi && hi.is_finite())
        {
            return bad(Setting::Rolling, "0 <= slowest <= fastest", format!("{lo} to {hi}"));
        }
        if !(self.limit_s > 0.0 && self.limit_s <= 60.0) {
            return bad(Setting::Limit, "more than 0 and at most 60 s", self.limit_s.to_string());
        }
        if let Some(after_s) = self.after_s.filter(|s| !(0.0..=600.0).contains(s)) {
            return bad(Setting::Named("after"), "0 to 600 s", after_s.to_string());
        }
        Ok(())
    }
}

/// The start of a planned trial.
pub fn start_of(trial: &Trial) -> InitialState {
    InitialState {
        ball_xy: Some(trial.ball),
        ball_velocity: trial.ball_velocity,
        goal_xy: Some(trial.goal),
        ..InitialState::nominal(trial.motion)
    }
}

/// How evaluation episodes differ from training: after the motion its last pose is held, and nothing but time ends them.
pub fn rules_of(options: &ShootingOptions, control_dt_s: f64) -> (EpisodeRules, usize) {
    let limit_s = options.limit_s + options.after_s.unwrap_or(0.0);
    let steps = (limit_s / control_dt_s).round() as usize;
    let time_limit = TimeLimit::Steps(u32::try_from(steps).unwrap_or(u32::MAX));
    (EpisodeRules { time_limit, ..EpisodeRules::evaluation() }, steps)
}

/// Runs the protocol. A run that was stopped reports the trials that ended.
///
/// # Errors
/// As [`run_episodes`], or if an option makes no sense, or no motion leaves room for the ball.
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
) -> Result<ShootingReport, EvalError> {
    let trials = plan(setup, options)?;
    let outcomes = outcomes(setup, policy, options, &trials)?;
    Ok(ShootingReport::new(setup.engine.facts(&setup.preset), options, outcomes))
}

/// The outcomes of the planned trials that ended.
pub(crate) fn outcomes(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
    trials: &[Trial],
) -> Result<Vec<Outcome>, EvalError> {
    let outcomes = outcomes_beside(setup, policy, options, trials, |_| (), |()| ())?;
    Ok(outcomes.into_iter().map(|(outcome, ())| outcome).collect())
}

/// As [`outcomes`], with what another observer found in each trial.
pub(crate) fn outcomes_beside<O: Observer, T: Serialize + DeserializeOwned>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
    trials: &[Trial],
    other: impl Fn(usize) -> O + Sync,
    found: impl Fn(O) -> T,
) -> Result<Vec<(Outcome, T)>, EvalError> {
    let (starts, rules, steps) = course(setup, options, trials);
    let watch = |i| Beside(Watch::new(setup, options), other(i));
    // An outcome's path is not written with it.
    let outcome = |i: usize, Beside(watch, other): Beside<Watch, O>| {
        let mut outcome = watch.outcome(trials[i].clone(), setup);
        let path = core::mem::take(&mut outcome.path);
        (outcome, path, found(other))
    };
    let outcomes = run_shared(setup, policy, &starts, rules, steps, watch, outcome)?;
    Ok(outcomes.into_iter().map(|(_, (outcome, path, found))| (Outcome { path, ..outcome }, found)).collect())
}

/// As [`evaluate`] with trials that were planned before, with the number and the trace of every trial in the report's order. The same
/// trials in several engines must be planned once: the motion for a rolling ball may depend on how the engine's ball slows down.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_traced(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
    trials: &[Trial],
) -> Result<(ShootingReport, Vec<(usize, Trace)>), EvalError> {
    let observer = |_| Traced { watch: Watch::new(setup, options), trace: Trace::default(), ball: true };
    let watches = run(setup, policy, options, trials, observer)?;
    let (mut outcomes, mut traces) = (Vec::new(), Vec::new());
    for (i, Traced { watch, trace, .. }) in watches {
        outcomes.push(watch.outcome(trials[i].clone(), setup));
        traces.push((i, trace));
    }
    Ok((ShootingReport::new(setup.engine.facts(&setup.preset), options, outcomes), traces))
}

/// The observers of the trials that ended, with their numbers.
fn run<O: Observer>(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ShootingOptions,
    trials: &[Trial],
    observer: impl Fn(usize) -> O + Sync,
) -> Result<Vec<(usize, O)>, EvalError> {
    let (starts, rules, steps) = course(setup, options, trials);
    run_episodes(setup, policy, &starts, rules, steps, observer)
}

/// Starts of the trials, rules and control steps.
fn course(
    setup: &EvalSetup,
    options: &ShootingOptions,
    trials: &[Trial],
) -> (Vec<InitialState>, EpisodeRules, usize) {
    let (rules, steps) = rules_of(options, setup.preset.control_dt_s());
    (trials.iter().map(start_of).collect(), rules, steps)
}
