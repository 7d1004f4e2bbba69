//! The same shots in both engines: where they agree, and what went apart first where they do not.

use std::fmt::Write;

use paid_task::EnvSample;
use serde::Serialize;

use crate::EvalError;
use crate::engine::Engine;
use crate::episodes::{Arena, Ending, Observer};
use crate::metrics::statistics::Share;
use crate::policy::PolicyMaker;
use crate::shooting::{Outcome, ShootingOptions, ShootingReport, evaluate_traced};
use crate::table::{Table, number};

/// From these differences on a quantity counts as diverged: well above what a millisecond of contact timing does, well
/// below what decides a shot.
const JOINT_RAD: f64 = 0.15;
const BASE_M: f64 = 0.05;
const BASE_RAD: f64 = 0.15;
const BALL_M: f64 = 0.1;
const BALL_SPEED: f64 = 0.5;

/// The motion of robot and ball in one trial.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    rows: Vec<Row>,
}

/// One control step.
#[derive(Clone, Debug)]
struct Row {
    base: [f64; 3],
    /// Base frame in the world, row-major.
    rot: [[f64; 3]; 3],
    joints: Vec<f32>,
    ball: [f64; 3],
    ball_vel: [f64; 3],
}

/// Records a trace beside another observer.
pub(crate) struct Traced<O> {
    pub watch: O,
    pub trace: Trace,
}

impl<O: Observer> Observer for Traced<O> {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        let base = &sample.bodies[0];
        self.trace.rows.push(Row {
            base: base.pos,
            rot: base.rot,
            joints: sample.joint_pos.iter().map(|q| *q as f32).collect(),
            ball: sample.ball_pos,
            ball_vel: sample.ball_vel,
        });
        self.watch.observe(sample, ended)
    }
}

/// The first quantity that went apart.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Divergence {
    /// Time since the start [s].
    pub time_s: f64,
    /// `base position`, `base orientation`, `ball position`, `ball velocity` or `joint <name>`.
    pub quantity: String,
    /// The difference then [m, rad or m/s].
    pub difference: f64,
}

fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt()
}

/// Angle between two orientations [rad].
fn angle(a: &[[f64; 3]; 3], b: &[[f64; 3]; 3]) -> f64 {
    let trace: f64 = a.as_flattened().iter().zip(b.as_flattened()).map(|(x, y)| x * y).sum();
    (0.5 * (trace - 1.0)).clamp(-1.0, 1.0).acos()
}

/// The first step at which `a` and `b` differ beyond the tolerances; of several quantities in that step the one that is
/// furthest beyond its tolerance. `None` while they stay together.
fn divergence(a: &Trace, b: &Trace, joints: &[String], control_dt_s: f64) -> Option<Divergence> {
    for (step, (a, b)) in a.rows.iter().zip(&b.rows).enumerate() {
        let mut found = vec![
            ("base position".to_owned(), distance(a.base, b.base), BASE_M),
            ("base orientation".to_owned(), angle(&a.rot, &b.rot), BASE_RAD),
            ("ball position".to_owned(), distance(a.ball, b.ball), BALL_M),
            ("ball velocity".to_owned(), distance(a.ball_vel, b.ball_vel), BALL_SPEED),
        ];
        for ((x, y), name) in a.joints.iter().zip(&b.joints).zip(joints) {
            found.push((format!("joint {name}"), f64::from((x - y).abs()), JOINT_RAD));
        }
        let excess = |f: &(String, f64, f64)| f.1 / f.2;
        let worst = found.into_iter().max_by(|x, y| excess(x).total_cmp(&excess(y)))?;
        if excess(&worst) > 1.0 {
            let (quantity, difference, _) = worst;
            return Some(Divergence { time_s: step as f64 * control_dt_s, quantity, difference });
        }
    }
    None
}

/// One trial in both engines.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Number of the trial in both reports.
    pub trial: usize,
    /// Grid place [m].
    pub place: [f64; 2],
    /// Goals: built-in, MuJoCo.
    pub goal: [bool; 2],
    /// Contacts: built-in, MuJoCo.
    pub contact: [bool; 2],
    /// Falls: built-in, MuJoCo.
    pub fell: [bool; 2],
    /// What went apart first.
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
/// As [`crate::shooting::evaluate`].
pub fn evaluate(
    arena: &Arena,
    scene: &paid_mujoco::SceneOptions,
    policy: &PolicyMaker,
    options: &ShootingOptions,
) -> Result<AgreementReport, EvalError> {
    let with = |engine| Arena { engine, ..arena.clone() };
    let (builtin, ours) = evaluate_traced(&with(Engine::Builtin), policy, options)?;
    let (mujoco, theirs) = evaluate_traced(&with(Engine::Mujoco(Box::new(scene.clone()))), policy, options)?;
    let joints: Vec<String> = arena.robot.joints.iter().map(|j| j.name.clone()).collect();
    let dt = arena.preset.control_dt_s();
    let both = |f: fn(&Outcome) -> bool, a: &Outcome, b: &Outcome| [f(a), f(b)];
    let mut pairs = Vec::new();
    // Trials are in the order of their numbers; a stopped run has gaps.
    for ((i, ours), a) in ours.iter().zip(&builtin.trials) {
        let Ok(k) = theirs.binary_search_by_key(i, |(j, _)| *j) else { continue };
        let b = &mujoco.trials[k];
        pairs.push(Pair {
            trial: *i,
            place: a.trial.place,
            goal: both(|o| o.goal, a, b),
            contact: both(|o| o.contact, a, b),
            fell: both(|o| o.fell, a, b),
            first: divergence(ours, &theirs[k].1, &joints, dt),
        });
    }
    Ok(AgreementReport {
        same_outcome: Share::of(pairs.iter().map(|p| p.goal[0] == p.goal[1])),
        same_contact: Share::of(pairs.iter().map(|p| p.contact[0] == p.contact[1])),
        builtin,
        mujoco,
        pairs,
    })
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
            let _ = writeln!(out, "\nwhat went apart first, {title}\n{}", self.first_table(disagreeing));
        }
        out
    }

    /// How often each quantity went apart first, and when.
    fn first_table(&self, disagreeing: bool) -> Table {
        let mut found: Vec<(&str, Vec<f64>)> = Vec::new();
        let mut together = 0;
        for pair in self.pairs.iter().filter(|p| !disagreeing || p.goal[0] != p.goal[1]) {
            let Some(first) = &pair.first else {
                together += 1;
                continue;
            };
            match found.iter_mut().find(|(name, _)| *name == first.quantity) {
                Some((_, times)) => times.push(first.time_s),
                None => found.push((&first.quantity, vec![first.time_s])),
            }
        }
        found.sort_by_key(|(name, times)| (usize::MAX - times.len(), *name));
        let mut table = Table::new(&["quantity", "", "trials", "median time [s]"]);
        for (name, times) in &mut found {
            times.sort_by(f64::total_cmp);
            let median = number(times[times.len() / 2], 2);
            table.row([(*name).to_owned(), String::new(), times.len().to_string(), median]);
        }
        table.row(["none".into(), String::new(), together.to_string(), "-".into()]);
        table
    }

    /// One line a trial.
    pub fn csv(&self) -> String {
        let mut out = String::from(
            "trial,x,y,goal_builtin,goal_mujoco,contact_builtin,contact_mujoco,fell_builtin,fell_mujoco,\
             first_time_s,first_quantity,first_difference\n",
        );
        for p in &self.pairs {
            let first = p
                .first
                .as_ref()
                .map_or(",,".to_owned(), |f| format!("{:.2},{},{:.5}", f.time_s, f.quantity, f.difference));
            let _ = writeln!(
                out,
                "{},{},{},{},{},{},{},{},{},{first}",
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

#[cfg(test)]
mod tests {
    use super::*;

    fn trace(steps: usize, row: impl Fn(usize, &mut Row)) -> Trace {
        let rows = (0..steps).map(|t| {
            let mut r = Row {
                base: [0.0; 3],
                rot: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                joints: vec![0.0; 2],
                ball: [0.0; 3],
                ball_vel: [0.0; 3],
            };
            row(t, &mut r);
            r
        });
        Trace { rows: rows.collect() }
    }

    fn joints() -> Vec<String> {
        vec!["hip".to_owned(), "knee".to_owned()]
    }

    #[test]
    fn the_first_quantity_beyond_its_tolerance_is_named_with_its_time() {
        let still = trace(50, |_, _| ());
        // The ball leaves at step 30, the knee was 0.2 rad off from step 20 on.
        let other = trace(50, |t, r| {
            r.joints[1] = if t >= 20 { 0.2 } else { 0.1 };
            r.ball[0] = if t >= 30 { 1.0 } else { 0.0 };
        });
        let first = divergence(&still, &other, &joints(), 0.02).expect("they differ");
        assert_eq!((first.quantity.as_str(), first.time_s), ("joint knee", 0.4));
        assert!((first.difference - 0.2).abs() < 1e-6);
    }

    #[test]
    fn of_two_quantities_in_one_step_the_worse_is_named() {
        let still = trace(3, |_, _| ());
        let (s, c) = 0.5_f64.sin_cos();
        let other = trace(3, |_, r| {
            r.rot = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
            r.ball_vel = [0.6, 0.0, 0.0];
        });
        let first = divergence(&still, &other, &joints(), 0.02).expect("they differ");
        assert_eq!(first.quantity, "base orientation");
        assert!((first.difference - 0.5).abs() < 1e-9, "half a radian about z");
    }

    #[test]
    fn small_differences_and_unequal_lengths_are_no_divergence() {
        let a = trace(10, |_, r| r.base[2] = 0.04);
        assert_eq!(divergence(&a, &trace(20, |_, _| ()), &joints(), 0.02), None);
    }
}
