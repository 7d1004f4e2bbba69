//! Matches of the demo policy on the built-in engine.

#[expect(dead_code, reason = "other tests use the rest")]
mod common;

use paid_eval::episodes::EvalSetup;
use paid_eval::matches::{self, MatchOptions, MatchReport};
use paid_eval::policy::Driver;

#[test]
fn a_match_goes_on_where_the_robot_stands_and_repeats_whatever_runs_beside_it() {
    let (mut setup, plain) = common::demo();
    let rule = ["ball.after_strike.show=where_it_lay".to_owned()];
    setup.preset = setup.preset.with_overrides(&rule).expect("valid");
    let maker = || Ok(Box::new(plain.clone()) as Box<dyn Driver>);
    let run = |matches: usize, threads: usize| -> MatchReport {
        let setup = EvalSetup { threads, ..setup.clone() };
        let options = MatchOptions { kicks: 2, matches, ..MatchOptions::default() };
        let (report, films) = matches::evaluate(&setup, &maker, &options, 1).expect("runs");
        assert_eq!(films.len(), 1);
        assert!(films[0].poses.len() > 20, "a film of the first match's first kick");
        report
    };
    let (one, three) = (run(1, 1), run(3, 2));
    assert_eq!(three.matches.len(), 3);
    assert_eq!(one.matches[0], three.matches[0], "a match does not depend on those beside it");
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
