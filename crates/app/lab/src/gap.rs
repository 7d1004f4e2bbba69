//! Which difference between the engines matters: the same shots in the built-in engine and in MuJoCo, whose scene takes over the
//! built-in engine's ways one at a time.

use std::fmt::Write;

use paid_eval::EvalError;
use paid_eval::engine::EngineChoice;
use paid_eval::episodes::EvalSetup;
use paid_eval::knowledge::Knowledge;
use paid_eval::metrics::statistics::Share;
use paid_eval::policy::DriverMaker;
use paid_eval::shooting::{CellScore, ShootingOptions, ShootingReport, evaluate_traced, plan};
use paid_eval::trace::Trace;
use paid_lanes::Isa;
use paid_mujoco::{BallOptions, Cone, FootShapes, PdControl, SceneOptions};
use paid_physics::EnvParams;
use paid_plot::{Table, number};
use paid_task::TaskPreset;
use serde::Serialize;

use crate::agreement::{pairs, same};
use crate::like_mujoco::like_mujoco;

/// A change of MuJoCo's scene toward the built-in engine.
#[derive(Clone, Copy, Debug)]
pub struct Difference {
    /// Short name.
    pub name: &'static str,
    /// What MuJoCo does then.
    pub what: &'static str,
    /// Whether it is about the ball.
    pub ball: bool,
    /// Whether it is left out where differences are taken together: a coarser step or a harder contact beside a bouncing ball is more
    /// than MuJoCo's solver can follow.
    pub alone: bool,
    change: fn(&mut SceneOptions, &TaskPreset),
}

/// The single differences. Numbers are those of the task's preset.
pub const DIFFERENCES: [Difference; 10] = [
    Difference {
        name: "soles",
        what: "four spheres a foot instead of seven capsules",
        ball: false,
        alone: false,
        change: |s, _| s.feet = FootShapes::Sole,
    },
    Difference {
        name: "implicit PD",
        what: "joint control with the next velocity's damping",
        ball: false,
        alone: false,
        change: |s, _| s.pd = PdControl::Implicit,
    },
    Difference {
        name: "physics step",
        what: "the built-in engine's step",
        ball: false,
        alone: true,
        change: |s, task| {
            s.physics_dt_s = task.scene.physics_dt_s;
            s.substeps = (task.control_dt_s() / s.physics_dt_s).round() as usize;
        },
    },
    Difference {
        name: "circular cone",
        what: "friction the same in all directions",
        ball: false,
        alone: false,
        change: |s, _| s.cone = Cone::Elliptic,
    },
    Difference {
        name: "floor friction",
        what: "the robot's dynamic friction on the built-in ground",
        ball: false,
        alone: false,
        change: |s, task| {
            let robot = EnvParams::default().robot;
            s.floor.friction = s.floor.like_builtin(robot, &task.scene).friction;
        },
    },
    Difference {
        name: "stiff floor",
        what: "contact time of the floor 4 ms",
        ball: false,
        alone: true,
        change: |s, _| s.floor.solref[0] = 0.004,
    },
    Difference {
        name: "ball friction",
        what: "the ball's dynamic friction on the built-in ground",
        ball: true,
        alone: false,
        change: |s, task| ball(s, |b| b.friction = builtin(*b, task).friction),
    },
    Difference {
        name: "ball damping",
        what: "the ball is slowed as in the built-in engine",
        ball: true,
        alone: false,
        change: |s, _| ball(s, |b| b.damped = true),
    },
    Difference {
        name: "bouncing ball",
        what: "contacts with the ball give back its restitution on the built-in ground",
        ball: true,
        alone: false,
        change: |s, task| ball(s, |b| b.solref = builtin(*b, task).solref),
    },
    Difference {
        name: "stiff ball",
        what: "contact time of the ball 5 ms",
        ball: true,
        alone: true,
        change: |s, _| ball(s, |b| b.solref[0] = 0.005),
    },
];

fn ball(scene: &mut SceneOptions, change: impl FnOnce(&mut BallOptions)) {
    if let Some(ball) = &mut scene.ball {
        change(ball);
    }
}

/// The ball with the contact that it has in the built-in engine.
fn builtin(ball: BallOptions, task: &TaskPreset) -> BallOptions {
    ball.like_builtin(task.ball_params, &task.scene)
}

/// One run against the built-in engine's.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapRow {
    /// Name of the difference or of what was run.
    pub name: String,
    /// In words.
    pub what: String,
    /// Scores of the run.
    pub score: CellScore,
    /// Trials with the built-in engine's outcome (goal or not); `None` for that engine itself.
    pub same_outcome: Option<Share>,
    /// Trials with a contact in both or in neither.
    pub same_contact: Option<Share>,
    /// Median time until a quantity went apart `[s]`, of the trials in which one did.
    pub apart_s: Option<f64>,
}

/// All runs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct GapReport {
    /// What was run in the built-in engine and in MuJoCo's own scene.
    pub titles: Vec<String>,
    /// What the policy knew of ball and goal, in every row.
    pub knowledge: Option<Knowledge>,
    /// The built-in engine, the same with another rounding (what agreement is possible at all) and with MuJoCo's contacts, MuJoCo's own scene, then one
    /// difference at a time, then several together.
    pub rows: Vec<GapRow>,
}

/// Runs the protocol once for every row. `scene` is the one that the differences change. A stopped evaluation has fewer rows.
///
/// # Errors
/// As [`paid_eval::shooting::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    scene: &SceneOptions,
    policy: &DriverMaker,
    options: &ShootingOptions,
) -> Result<GapReport, EvalError> {
    let with = |engine: EngineChoice, isa: Isa| EvalSetup { engine, isa, ..setup.clone() };
    let trials = plan(&with(EngineChoice::Mujoco(Box::new(scene.clone())), setup.isa), options)?;
    let run = |engine: EngineChoice, isa: Isa| evaluate_traced(&with(engine, isa), policy, options, &trials);
    let reference = run(EngineChoice::Builtin, setup.isa)?;
    let mut report = GapReport {
        titles: vec![reference.0.title()],
        knowledge: reference.0.engine.knowledge.clone(),
        rows: Vec::new(),
    };
    report.rows.push(GapRow {
        name: "built-in engine".into(),
        what: "the reference".into(),
        score: reference.0.total.clone(),
        same_outcome: None,
        same_contact: None,
        apart_s: None,
    });
    if setup.isa != Isa::Portable && !setup.monitor.stopped() {
        let other = run(EngineChoice::Builtin, Isa::Portable)?;
        report.rows.push(row(
            setup,
            "other rounding",
            "the built-in engine in portable arithmetic",
            &reference,
            &other,
        ));
    }
    if !setup.monitor.stopped() {
        let preset = like_mujoco(&setup.preset, scene);
        let softer = EvalSetup { preset, ..with(EngineChoice::Builtin, setup.isa) };
        let other = evaluate_traced(&softer, policy, options, &trials)?;
        let what = "the built-in engine with MuJoCo's contacts";
        report.rows.push(row(setup, "as MuJoCo", what, &reference, &other));
    }
    let each = |picked: fn(&Difference) -> bool| DIFFERENCES.iter().filter(move |d| picked(d));
    let mut changes: Vec<(&str, String, Vec<&Difference>)> =
        vec![("MuJoCo", "its own scene".into(), Vec::new())];
    changes.extend(DIFFERENCES.iter().map(|d| (d.name, d.what.to_owned(), vec![d])));
    changes.push((
        "robot together",
        "soles, implicit PD, cone and floor friction".into(),
        each(|d| !d.ball && !d.alone).collect(),
    ));
    changes.push((
        "ball together",
        "friction, damping and bounce of the ball".into(),
        each(|d| d.ball && !d.alone).collect(),
    ));
    changes.push(("all together", "both of these".into(), each(|d| !d.alone).collect()));
    for (name, what, differences) in changes {
        if setup.monitor.stopped() {
            break;
        }
        let mut changed = scene.clone();
        for difference in &differences {
            (difference.change)(&mut changed, &setup.preset);
        }
        changed.resolve_contacts();
        let theirs = run(EngineChoice::Mujoco(Box::new(changed)), setup.isa)?;
        if differences.is_empty() {
            report.titles.push(theirs.0.title());
        }
        report.rows.push(row(setup, name, &what, &reference, &theirs));
    }
    Ok(report)
}

type Run = (ShootingReport, Vec<(usize, Trace)>);

fn row(setup: &EvalSetup, name: &str, what: &str, reference: &Run, theirs: &Run) -> GapRow {
    let pairs = pairs(setup, (&reference.0, &reference.1), (&theirs.0, &theirs.1));
    let (same_outcome, same_contact) = same(&pairs);
    let mut times: Vec<f64> = pairs.iter().filter_map(|p| p.first.as_ref()).map(|f| f.time_s).collect();
    times.sort_by(f64::total_cmp);
    GapRow {
        name: name.to_owned(),
        what: what.to_owned(),
        score: theirs.0.total.clone(),
        same_outcome: Some(same_outcome),
        same_contact: Some(same_contact),
        apart_s: times.get(times.len() / 2).copied(),
    }
}

/// Titles of the table and of the CSV.
const COLUMNS: [&str; 11] = [
    "run",
    "what",
    "trials",
    "same outcome",
    "same contact",
    "apart [s]",
    "success",
    "accuracy",
    "contact",
    "ball [m/s]",
    "falls",
];

impl GapRow {
    fn cells(&self) -> [String; 11] {
        let share = |s: &Share| format!("{:.1}%", 100.0 * s.share);
        let maybe = |s: &Option<Share>| s.as_ref().map_or("-".to_owned(), share);
        let value = |v: Option<f64>, digits| v.map_or("-".to_owned(), |v| number(v, digits));
        let s = &self.score;
        [
            self.name.clone(),
            self.what.clone(),
            s.success.trials.to_string(),
            maybe(&self.same_outcome),
            maybe(&self.same_contact),
            value(self.apart_s, 2),
            share(&s.success),
            value(s.accuracy, 3),
            share(&s.contact),
            value(s.ball_speed, 2),
            share(&s.falls_ever),
        ]
    }
}

impl GapReport {
    /// The rows as text.
    pub fn table(&self) -> String {
        let mut table = Table::new(&COLUMNS);
        self.rows.iter().for_each(|row| table.row(row.cells()));
        format!("{}\n\n{table}", self.titles.join("\n"))
    }

    /// The rows as CSV.
    pub fn csv(&self) -> String {
        let mut out = format!("{},knowledge\n", COLUMNS.join(","));
        let knowledge = self.knowledge.as_ref().map_or("-", Knowledge::name);
        for row in &self.rows {
            // Writing to a string cannot fail.
            let _ = writeln!(out, "{},{knowledge}", row.cells().map(|cell| cell.replace(',', ";")).join(","));
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_mujoco::contact::restitution;

    /// It once took the ball's own restitution, without the ground's share: 0.75 instead of 0.6.
    #[test]
    fn the_bouncing_ball_has_the_restitution_of_training() {
        let task = TaskPreset::builtin("paper_stage2").expect("built in");
        let mut scene = SceneOptions::default();
        for difference in DIFFERENCES.iter().filter(|d| d.ball && !d.alone) {
            (difference.change)(&mut scene, &task);
        }
        let training = task.scene.contact_with_ground(task.ball_params.material);
        let ball = scene.ball.expect("a ball");
        assert!(training.restitution < task.ball_params.material.restitution);
        assert!((restitution(ball.solref[1]) - training.restitution).abs() < 1e-12, "{ball:?}");
        assert_eq!((ball.friction[0], ball.damped), (training.dynamic_friction, true));
        // The differences of the ball together are the conversion, but for the ball's mass and size, which are the task's.
        let params = scene.ball.expect("a ball").params;
        let whole = BallOptions { params, ..builtin(BallOptions::default(), &task) };
        assert_eq!(ball, whole);
    }

    #[test]
    fn every_difference_changes_the_scene_and_no_two_the_same() {
        let task = TaskPreset::builtin("paper_stage2").expect("built in");
        let mut seen = vec![SceneOptions::default()];
        for difference in DIFFERENCES {
            let mut scene = SceneOptions::default();
            (difference.change)(&mut scene, &task);
            assert!(!seen.contains(&scene), "{}", difference.name);
            assert_eq!(difference.ball, scene.ball != SceneOptions::default().ball, "{}", difference.name);
            seen.push(scene);
        }
    }

    #[test]
    fn no_text_breaks_the_csv() {
        assert!(DIFFERENCES.iter().all(|d| !d.name.contains(',') && !d.what.contains(',')));
    }
}
