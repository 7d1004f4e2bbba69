//! Matches of the demo policy on the built-in engine.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};

use paid_eval::EvalError;
use paid_eval::episodes::EvalSetup;
use paid_eval::matches::{self, Audience, KickOutcome, MatchOptions, MatchReport, Spectacle, Spectator};
use paid_eval::policy::{Driver, DriverInput};

#[test]
fn a_match_goes_on_where_the_robot_stands_and_repeats_whatever_runs_beside_it() {
    let (mut setup, plain) = crate::common::demo();
    let rule = ["ball.after_strike.show=where_it_lay".to_owned()];
    setup.preset = setup.preset.with_overrides(&rule).expect("valid");
    let maker = || Ok(Box::new(plain.clone()) as Box<dyn Driver>);
    let run = |matches: usize, threads: usize| -> MatchReport {
        let setup = EvalSetup { threads, ..setup.clone() };
        let options = MatchOptions { kicks: 2, matches, ..MatchOptions::default() };
        let audience = Audience { filmed: 1, spectator: None };
        let (report, films) = matches::evaluate(&setup, &maker, &options, audience).expect("runs");
        assert_eq!(films.len(), 1);
        assert!(films[0].poses.len() > 20, "a film of the first match's first kick");
        report
    };
    let (one, three) = (run(1, 1), run(3, 2));
    assert_eq!(three.matches.len(), 3);
    assert_eq!(one.matches[0], three.matches[0], "a match does not depend on the others");
    for m in &three.matches {
        assert!(m.kicks.len() == 2 || m.fell, "{m:?}");
        for kick in &m.kicks {
            assert!((0.5..=2.0).contains(&kick.ball[0]) && (-1.0..=1.0).contains(&kick.ball[1]), "{kick:?}");
            assert!(kick.goal_center[1].atan2(kick.goal_center[0]).abs() <= 10.0_f64.to_radians());
            assert!((kick.goal_center[0].hypot(kick.goal_center[1]) - 5.0).abs() < 1e-9);
        }
        let [first, second] = &m.kicks[..] else { continue };
        assert!(first.ball != second.ball && first.seconds > 2.0, "{m:?}");
    }
    // It meets the ball again from where it stood, and the kicks that it stands through end near the reference.
    let second: Vec<_> = three.matches.iter().filter_map(|m| m.kicks.get(1)).collect();
    assert!(second.iter().any(|k| k.contact), "{second:?}");
    assert!(three.total.drift_m.expect("kicks on both feet") < 1.0, "{:?}", three.total);
}

/// Counts how often another kick is announced.
struct Counting {
    plain: Box<dyn Driver>,
    kicks: Arc<AtomicUsize>,
}

impl Driver for Counting {
    fn obs_dim(&self) -> Option<usize> {
        self.plain.obs_dim()
    }
    fn action_dim(&self) -> usize {
        self.plain.action_dim()
    }
    fn begin(&mut self, envs: usize) {
        self.plain.begin(envs);
    }
    fn forget(&mut self, env: usize) {
        self.kicks.fetch_add(1, Ordering::Relaxed);
        self.plain.forget(env);
    }
    fn act(&mut self, seen: DriverInput<'_>, actions: &mut [f32]) -> Result<(), EvalError> {
        self.plain.act(seen, actions)
    }
}

#[test]
fn a_policy_forgets_between_the_kicks_of_a_match_as_it_did_between_episodes() {
    let (setup, plain) = crate::common::demo();
    let kicks = Arc::new(AtomicUsize::new(0));
    let maker = || {
        let (plain, kicks) = (Box::new(plain.clone()) as Box<dyn Driver>, Arc::clone(&kicks));
        Ok(Box::new(Counting { plain, kicks }) as Box<dyn Driver>)
    };
    let options = MatchOptions { kicks: 2, matches: 2, ..MatchOptions::default() };
    let (report, _) = matches::evaluate(&setup, &maker, &options, Audience::default()).expect("runs");
    let further: usize = report.matches.iter().map(|m| m.kicks.len() - 1).sum();
    assert!(further > 0, "{report:?}");
    assert_eq!(kicks.load(Ordering::Relaxed), further);
}

/// Of each match: control steps, kicks, and whether the last one was called the last.
#[derive(Default)]
struct Crowd(Mutex<[(u32, usize, bool); 2]>);

impl Spectator for Crowd {
    fn see(&self, moment: &Spectacle<'_>) {
        let (steps, _, over) = &mut self.0.lock().expect("no panic")[moment.number];
        assert!(!*over && moment.sample.step == *steps, "every step once, none after the end");
        *steps += 1;
    }

    fn kicked(&self, number: usize, kick: &KickOutcome, last: bool) {
        let (_, kicks, over) = &mut self.0.lock().expect("no panic")[number];
        *kicks += 1;
        assert!(last || !kick.fell, "a fall ends a match");
        *over = last;
    }
}

#[test]
fn who_looks_on_sees_every_step_and_changes_nothing() {
    let (setup, plain) = crate::common::demo();
    let maker = || Ok(Box::new(plain.clone()) as Box<dyn Driver>);
    let options = MatchOptions { kicks: 2, matches: 2, ..MatchOptions::default() };
    let crowd = Crowd::default();
    let watched = Audience { filmed: 0, spectator: Some(&crowd) };
    let (seen, _) = matches::evaluate(&setup, &maker, &options, watched).expect("runs");
    let (unseen, _) = matches::evaluate(&setup, &maker, &options, Audience::default()).expect("runs");
    assert_eq!(seen.matches, unseen.matches);
    for (m, (steps, kicks, over)) in seen.matches.iter().zip(crowd.0.into_inner().expect("no panic")) {
        let seconds: f64 = m.kicks.iter().map(|k| k.seconds).sum();
        let expected = (seconds / setup.preset.control_dt_s()).round() as u32 + 1;
        assert_eq!((steps, kicks, over), (expected, m.kicks.len(), true), "{m:?}");
    }
}
