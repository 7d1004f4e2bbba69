//! What goes wrong on a real robot, one thing at a time in MuJoCo: pushes, a payload, a weak motor, late targets, a slippery floor; and
//! other grounds.

mod report;
mod trouble;

use paid_lanes::rng::Rng;
use paid_mujoco::SceneOptions;
use serde::Serialize;

use crate::EvalError;
use crate::engine::EngineChoice;
use crate::episodes::EvalSetup;
use crate::policy::DriverMaker;
use crate::shooting::{CellScore, Grid, ShootingOptions, outcomes_beside, plan};
use trouble::Pusher;

pub use report::{RobustnessReport, RobustnessRow};
pub use trouble::{Series, Trouble};

/// The robot is watched for this long after its kick, but no longer than the time limit `[s]`: a push comes up to a second after it, and a fall takes another.
const WATCHED_S: f64 = 3.0;

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RobustnessOptions {
    /// What goes wrong.
    pub series: Series,
    /// Shots at each of the 63 places of the effective workspace.
    pub trials: usize,
    /// Speed range of the balls `[m/s]`; `None` lies still.
    pub rolling: Option<[f64; 2]>,
    /// Time limit of a trial `[s]`.
    pub limit_s: f64,
}

/// Shoots in MuJoCo with each trouble of the series, whatever the setup's engine; `scene` is the usual one. The shots are the same in all rows. A
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
    for trouble in options.series.troubles() {
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
        "{}; {}; effective workspace, {} {} balls per place, robot displaced by up to 0.5 m and watched for \
         {watched_s} s after the kick{}",
        facts.name,
        options.series.says(),
        options.trials,
        if options.rolling.is_some() { "rolling" } else { "static" },
        facts.knowledge_text()
    );
    Ok(RobustnessReport::new(options.clone(), title, rows))
}
