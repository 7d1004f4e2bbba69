//! The same shots in both engines: where they agree, and what diverged first where they do not.

use std::fmt::Write;

use paid_eval::EvalError;
use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::metrics::statistics::Share;
use paid_eval::policy::DriverMaker;
use paid_eval::shooting::{Outcome, ShootingOptions, ShootingReport, evaluate_traced, plan};
use paid_eval::trace::Trace;
use paid_plot::{Table, number};
use serde::Serialize;

use crate::divergence::{Divergence, csv_fields, divergence, first_table};

/// One trial in both engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Number of the trial in both reports.
    pub trial: usize,
    /// Grid place `[m]`.
    pub place: [f64; 2],
    /// Goals: built-in, MuJoCo.
    pub goal: [bool; 2],
    /// Contacts: built-in, MuJoCo.
    pub contact: [bool; 2],
    /// Falls: built-in, MuJoCo.
    pub fell: [bool; 2],
    /// What diverged first.
    pub first: Option<Divergence>,
}

/// Both reports and their comparison.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AgreementReport {
    /// The built-in engine's report.
    pub builtin: ShootingReport,
    /// MuJoCo's.
    pub mujoco: ShootingReport,
    /// Trials with the same outcome (goal or not).
    pub same_outcome: Share,
    /// Trials with a contact in both or in neither.
    pub same_contact: Share,
    /// Every trial that both engines ran.
    pub pairs: Vec<Pair>,
}

/// Runs the protocol in the built-in engine and in MuJoCo with `scene`.
///
/// # Errors
/// As [`paid_eval::shooting::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    scene: &paid_mujoco::SceneOptions,
    policy: &DriverMaker,
    options: &ShootingOptions,
) -> Result<AgreementReport, EvalError> {
    let with = |engine| EvalSetup { engine, ..setup.clone() };
    let referee = with(EngineChoice::Mujoco(Box::new(scene.clone())));
    let trials = plan(&referee, options)?;
    let (builtin, ours) = evaluate_traced(&with(EngineChoice::Builtin), policy, options, &trials)?;
    let (mujoco, theirs) = evaluate_traced(&referee, policy, options, &trials)?;
    let pairs = pairs(setup, (&builtin, &ours), (&mujoco, &theirs));
    let (same_outcome, same_contact) = same(&pairs);
    Ok(AgreementReport { same_outcome, same_contact, builtin, mujoco, pairs })
}

/// Trials with the same outcome, and with a contact in both or in neither.
pub(crate) fn same(pairs: &[Pair]) -> (Share, Share) {
    (
        Share::of(pairs.iter().map(|p| p.goal[0] == p.goal[1])),
        Share::of(pairs.iter().map(|p| p.contact[0] == p.contact[1])),
    )
}

/// The trials that both runs finished, side by side.
pub(crate) fn pairs(
    setup: &EvalSetup,
    (first, ours): (&ShootingReport, &[(usize, Trace)]),
    (second, theirs): (&ShootingReport, &[(usize, Trace)]),
) -> Vec<Pair> {
    let joints: Vec<String> = setup.robot.joints.iter().map(|j| j.name.clone()).collect();
    let dt = setup.preset.control_dt_s();
    let both = |f: fn(&Outcome) -> bool, a: &Outcome, b: &Outcome| [f(a), f(b)];
    let mut pairs = Vec::new();
    // Trials are in the order of their numbers; a stopped run has gaps.
    for ((i, ours), a) in ours.iter().zip(&first.trials) {
        let Ok(k) = theirs.binary_search_by_key(i, |(j, _)| *j) else { continue };
        let b = &second.trials[k];
        pairs.push(Pair {
            trial: *i,
            place: a.trial.place,
            goal: both(|o| o.goal, a, b),
            contact: both(|o| o.contact, a, b),
            fell: both(|o| o.fell, a, b),
            first: divergence(ours, &theirs[k].1, &joints, dt),
        });
    }
    pairs
}

impl AgreementReport {
    /// The comparison as text.
    pub fn table(&self) -> String {
        let (a, b) = (&self.builtin.total, &self.mujoco.total);
        let mut scores = Table::new(&["figure", "", "built-in", "MuJoCo"]);
        let share = |s: &Share| format!("{:.1}%", 100.0 * s.share);
        let value = |v: Option<f64>| v.map_or("-".to_owned(), |v| number(v, 3));
        for (name, x, y) in [
            ("success", &a.success, &b.success),
            ("contact", &a.contact, &b.contact),
            ("correct foot of kicks", &a.correct_foot, &b.correct_foot),
            ("falls at any time", &a.falls_ever, &b.falls_ever),
        ] {
            scores.row([name.into(), String::new(), share(x), share(y)]);
        }
        for (name, x, y) in [
            ("accuracy (cosine)", a.accuracy, b.accuracy),
            ("ball speed [m/s]", a.ball_speed, b.ball_speed),
            ("foot speed at contact [m/s]", a.foot_speed, b.foot_speed),
        ] {
            scores.row([name.into(), String::new(), value(x), value(y)]);
        }
        let mut out = format!("{}\n{}\n\n{scores}\n", self.builtin.title(), self.mujoco.title());
        let count = |goals: [bool; 2]| self.pairs.iter().filter(|p| p.goal == goals).count();
        // Writing to a string cannot fail.
        let _ = writeln!(
            out,
            "the same outcome in {} of {} trials ({}); a goal in both {}, in the built-in engine alone {}, in MuJoCo alone {}, in neither {}",
            self.same_outcome.count,
            self.same_outcome.trials,
            share(&self.same_outcome),
            count([true, true]),
            count([true, false]),
            count([false, true]),
            count([false, false])
        );
        for (title, disagreeing) in [("all trials", false), ("trials with different outcomes", true)] {
            let picked = self.pairs.iter().filter(|p| !disagreeing || p.goal[0] != p.goal[1]);
            let first = first_table(picked.map(|p| p.first.as_ref()));
            let _ = writeln!(out, "\nwhat diverged first, {title}\n{first}");
        }
        out
    }

    /// One line per trial.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "trial,x,y,goal_builtin,goal_mujoco,contact_builtin,contact_mujoco,fell_builtin,fell_mujoco,\
             first_time_s,first_quantity,first_difference,knowledge\n",
        );
        let knowledge = self.builtin.engine.knowledge_name();
        for p in &self.pairs {
            let first = csv_fields(p.first.as_ref());
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{first},{knowledge}",
                p.trial,
                p.place[0],
                p.place[1],
                p.goal[0],
                p.goal[1],
                p.contact[0],
                p.contact[1],
                p.fell[0],
                p.fell[1]
            );
        }
        out
    }
}
