//! The same tracking runs in both engines: where they agree, and what diverged first.

use std::fmt::Write;

use paid_eval::EvalError;
use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::metrics::statistics::Share;
use paid_eval::policy::DriverMaker;
use paid_eval::tracking::{TrackingOptions, TrackingReport, evaluate_traced};
use serde::Serialize;

use crate::divergence::{Divergence, csv_fields, divergence, first_table};

/// One run in both engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackingPair {
    /// Number of the run in both reports.
    pub run: usize,
    /// Motion index.
    pub motion: usize,
    /// True without reset noise.
    pub exact: bool,
    /// Whether the motion was followed to its end: built-in, MuJoCo.
    pub completed: [bool; 2],
    /// Mean distance of bodies relative to the root `[mm]`: built-in, MuJoCo.
    pub mpjpe_mm: [f64; 2],
    /// What diverged first.
    pub first: Option<Divergence>,
}

/// Both reports and their comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TrackingAgreement {
    /// The built-in engine's report.
    pub builtin: TrackingReport,
    /// MuJoCo's.
    pub mujoco: TrackingReport,
    /// Runs that were completed in both or in neither.
    pub same_completion: Share,
    /// Every run that both engines ended.
    pub pairs: Vec<TrackingPair>,
}

/// Runs the protocol in the built-in engine and in MuJoCo with `scene`.
///
/// # Errors
/// As [`paid_eval::tracking::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    scene: &paid_mujoco::SceneOptions,
    policy: &DriverMaker,
    options: &TrackingOptions,
) -> Result<TrackingAgreement, EvalError> {
    let with = |engine| EvalSetup { engine, ..setup.clone() };
    let (builtin, ours) = evaluate_traced(&with(EngineChoice::Builtin), policy, options)?;
    let (mujoco, theirs) =
        evaluate_traced(&with(EngineChoice::Mujoco(Box::new(scene.clone()))), policy, options)?;
    let joints: Vec<String> = setup.robot.joints.iter().map(|j| j.name.clone()).collect();
    let mut pairs = Vec::new();
    // Runs are in the order of their numbers; a stopped evaluation has gaps.
    for ((run, trace), a) in ours.iter().zip(&builtin.runs) {
        let Ok(k) = theirs.binary_search_by_key(run, |(j, _)| *j) else { continue };
        let b = &mujoco.runs[k];
        pairs.push(TrackingPair {
            run: *run,
            motion: a.motion,
            exact: a.exact,
            completed: [a.completed, b.completed],
            mpjpe_mm: [a.errors.mpjpe_mm, b.errors.mpjpe_mm],
            first: divergence(trace, &theirs[k].1, &joints, setup.preset.control_dt_s()),
        });
    }
    let same_completion = Share::of(pairs.iter().map(|p| p.completed[0] == p.completed[1]));
    Ok(TrackingAgreement { builtin, mujoco, same_completion, pairs })
}

impl TrackingAgreement {
    /// The comparison as text.
    pub fn table(&self) -> String {
        let count = |done: [bool; 2]| self.pairs.iter().filter(|p| p.completed == done).count();
        let mut out = format!(
            "completed in both engines {}, in the built-in engine alone {}, in MuJoCo alone {}, in neither {} of {} runs\n",
            count([true, true]),
            count([true, false]),
            count([false, true]),
            count([false, false]),
            self.pairs.len()
        );
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "\nwhat diverged first\n{}",
            first_table(self.pairs.iter().map(|p| p.first.as_ref()))
        );
        out
    }

    /// One line per run.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "run,clip,exact,completed_builtin,completed_mujoco,mpjpe_builtin_mm,mpjpe_mujoco_mm,\
             first_time_s,first_quantity,first_difference\n",
        );
        for p in &self.pairs {
            let _ = writeln!(
                out,
                "{},{},{},{},{},{:.3},{:.3},{}",
                p.run,
                self.builtin.clips.get(p.motion).map_or("", |c| &c.name),
                p.exact,
                p.completed[0],
                p.completed[1],
                p.mpjpe_mm[0],
                p.mpjpe_mm[1],
                csv_fields(p.first.as_ref())
            );
        }
        out
    }
}
