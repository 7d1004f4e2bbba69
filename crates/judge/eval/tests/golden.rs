//! Small evaluations whose figures are known: the demo policy's goals, and an open-loop kick at balls next to the foot in both
//! engines.
//!
//! `PAID_GOLDEN=write cargo test -p paid-eval --test all golden::` writes the figures again; look at the difference before keeping it.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use crate::common::{Puppet, demo, setup};
use paid_eval::engine::EngineChoice;
use paid_eval::policy::Driver;
use paid_eval::shooting::{self, Grid, ShootingOptions};
use paid_eval::tracking::{self, TrackingOptions};
use paid_mujoco::Library;

/// Figures by name.
type Figures = BTreeMap<String, f64>;

fn figures(engine: EngineChoice) -> Figures {
    let mut out = Figures::new();
    let prefix = engine.name();
    let mut add = |name: &str, value: Option<f64>| {
        out.insert(format!("{prefix} {name}"), value.unwrap_or(-1.0));
    };
    let mut setup = setup("paper_stage2");
    setup.engine = engine;
    let puppet = Puppet::new(&setup);
    let maker = || Ok(Box::new(puppet.clone()) as Box<dyn Driver>);
    let options = ShootingOptions {
        grid: Grid { x: [0.3, 0.35], y: [0.05, 0.15], step: 0.05 },
        trials: 1,
        start_radius_m: 0.0,
        goal_distance_m: 0.4, // within reach of a ball that the puppet pushes at 0.2 m/s
        limit_s: 2.5,
        ..ShootingOptions::default()
    };
    let report = shooting::evaluate(&setup, &maker, &options).expect("runs");
    let total = &report.total;
    for (name, share) in [
        ("success", &total.success),
        ("contact", &total.contact),
        ("correct foot", &total.correct_foot),
        ("foot contact", &total.foot_contact),
        ("falls", &total.falls_ever),
    ] {
        add(name, Some(share.share));
    }
    add("accuracy", total.accuracy);
    add("ball speed", total.ball_speed);
    add("foot speed", total.foot_speed);
    for (i, trial) in report.trials.iter().enumerate() {
        add(&format!("kick {i} time"), trial.kick_time_s);
    }
    setup.preset = paid_task::TaskPreset::builtin("paper_stage1").expect("built in");
    let sets = vec!["own".to_owned(); setup.library.len()];
    let options = TrackingOptions { starts: 0, sets, limits: false };
    let report = tracking::evaluate(&setup, &maker, &options).expect("runs");
    let exact = report.sets[0].exact.expect("exact starts");
    add("mpjpe", Some(exact.errors.mpjpe_mm));
    add("g-mpjpe", Some(exact.errors.g_mpjpe_mm));
    add("velocity error", Some(exact.errors.velocity_error_mm));
    add("peak foot speed", Some(exact.foot_speed));
    out
}

/// Compares with the file, or writes it.
fn check(name: &str, found: &Figures) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/{name}.json"));
    if std::env::var_os("PAID_GOLDEN").is_some_and(|v| v == "write") {
        let text = serde_json::to_string_pretty(found).expect("numbers") + "\n";
        std::fs::write(&path, text).expect("writes");
        return;
    }
    let text = std::fs::read_to_string(&path).expect("the golden figures");
    let expected: Figures = serde_json::from_str(&text).expect("numbers");
    assert!(expected.keys().eq(found.keys()), "other figures: {:?} and {:?}", expected.keys(), found.keys());
    for (name, expected) in &expected {
        // Arithmetic of another machine moves the last digits; a changed rule or scene moves more.
        let near = (found[name] - expected).abs() <= 0.02 * expected.abs() + 1e-3;
        assert!(near, "{name}: expected {expected}, found {}", found[name]);
    }
}

/// The outcomes of 60 shots of the demo policy at the effective workspace.
#[derive(Debug, PartialEq, Eq)]
struct Counts {
    goals: usize,
    contacts: usize,
    correct_foot: usize,
    falls: usize,
}

/// Counts with a ball that lies still, and with a rolling one. The engine's portable lanes and the policy's plain loops round the same
/// way everywhere, so the counts are exact.
const KNOWN: [(Option<[f64; 2]>, Counts); 2] = [
    (None, Counts { goals: 59, contacts: 60, correct_foot: 60, falls: 0 }),
    (Some(shooting::ROLLING_SPEED), Counts { goals: 58, contacts: 60, correct_foot: 60, falls: 0 }),
];

#[test]
fn the_demo_policy_scores_the_known_goals() {
    let (setup, plain) = demo();
    let maker = || Ok(Box::new(plain.clone()) as Box<dyn Driver>);
    for (rolling, known) in KNOWN {
        let options = ShootingOptions {
            grid: Grid { step: 0.5, ..Grid::EFFECTIVE },
            trials: 3,
            rolling,
            ..ShootingOptions::default()
        };
        let report = shooting::evaluate(&setup, &maker, &options).expect("runs");
        let total = &report.total;
        assert_eq!(total.success.trials, 60);
        let found = Counts {
            goals: total.success.count,
            contacts: total.contact.count,
            correct_foot: total.correct_foot.count,
            falls: total.falls_ever.count,
        };
        assert_eq!(found, known, "{}", report.table());
    }
}

#[test]
fn the_built_in_engine_gives_the_known_figures() {
    let found = figures(EngineChoice::Builtin);
    check("builtin", &found);
    assert!(found["builtin success"] > 0.0, "a golden evaluation without a goal says little: {found:?}");
}

#[test]
fn mujoco_gives_the_known_figures() {
    let Some(_) = paid_testing::mujoco("mujoco_gives_the_known_figures", Library::get()) else { return };
    let found = figures(EngineChoice::Mujoco(Box::default()));
    check("mujoco", &found);
    assert!(found["mujoco success"] > 0.0, "a golden evaluation without a goal says little: {found:?}");
}

#[test]
fn a_stopped_evaluation_reports_the_trials_that_ended() {
    let setup = setup("paper_stage2");
    // Stopped in the second batch of trials, long before its end.
    let stopper = Arc::new(std::sync::atomic::AtomicUsize::new(0));
    let maker = || {
        let batch = stopper.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
        let mut puppet = Puppet::new(&setup);
        puppet.stop = (batch == 1).then(|| setup.monitor.clone());
        Ok(Box::new(puppet) as Box<dyn Driver>)
    };
    let options = ShootingOptions {
        grid: Grid { x: [0.5, 0.75], y: [0.0, 0.0], step: 0.25 },
        trials: 50,
        limit_s: 0.2,
        ..ShootingOptions::default()
    };
    let report = shooting::evaluate(&setup, &maker, &options).expect("runs");
    assert_eq!((report.trials.len(), report.planned()), (64, 100), "the first batch of 64 ended");
    assert!(report.table().contains("stopped: 64 of 100 trials"), "{}", report.table());
    assert_eq!(report.csv().lines().count(), 65);
    assert_eq!((report.cells[0].success.trials, report.cells[1].success.trials), (50, 14));
    // Another evaluation under the same monitor does not begin, and says so without inventing figures.
    let sets = vec!["own".to_owned(); setup.library.len()];
    let options = TrackingOptions { starts: 1, sets, limits: true };
    let report = tracking::evaluate(&setup, &maker, &options).expect("runs");
    assert_eq!((report.runs.len(), report.planned), (0, 4));
    assert!(report.sets[0].exact.is_none() && report.clips[0].exact_completed.is_none());
    assert!(report.table().contains("stopped: 0 of 4 runs"), "{}", report.table());
    assert!(report.error_bars().figure().svg().ends_with("</svg>\n"));
}
