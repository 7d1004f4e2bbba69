//! The worst shots of a report, as film strips.

use std::path::Path;

use paid_files::write_whole;
use paid_plot::{Canvas, Film, film_strip};
use serde::{Deserialize, Serialize};

use crate::EvalError;
use crate::episodes::{EvalSetup, run_again};
use crate::policy::DriverMaker;
use crate::results::to_json;
use crate::shooting::{Outcome, ShootingReport, rules_of, start_of};

/// Moments of a strip.
const MOMENTS: usize = 8;

/// A shot again.
#[derive(Clone, Debug)]
pub struct Strip {
    /// Its number in the report.
    pub trial: usize,
    /// Its outcome, in words.
    pub words: String,
    /// The moments around the kick.
    pub picture: Canvas,
}

/// A strip's file, for the page.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StripFile {
    /// File of the drawing, from the list's folder.
    pub picture: String,
    /// What it shows.
    pub words: String,
}

/// The outcome of a shot.
pub fn words(outcome: &Outcome, half_width_m: f64) -> String {
    let side = |lateral: f64| if lateral > 0.0 { "left" } else { "right" };
    let [x, y] = outcome.trial.place;
    let end = match outcome.lateral_m {
        _ if outcome.fell_in_clip => "fell before the clip's end".to_owned(),
        _ if !outcome.contact => "did not touch the ball".to_owned(),
        Some(lateral) if outcome.goal => {
            format!("goal, {:.2} m {} of the middle", lateral.abs(), side(lateral))
        }
        Some(lateral) => {
            format!("{:.2} m past the {} post", lateral.abs() - half_width_m, side(lateral))
        }
        None => "short of the goal".to_owned(),
    };
    let after = if outcome.fell && !outcome.fell_in_clip { ", then fell" } else { "" };
    format!("ball at ({x:.2}, {y:.2}) m, {}: {end}{after}", outcome.motion_name)
}

/// Numbers of the worst `count` shots, the worst first: falls, balls that were not met, misses by how far, then goals by how near to a post.
pub fn worst(report: &ShootingReport, count: usize) -> Vec<usize> {
    let badness = |o: &Outcome| {
        let miss = o.lateral_m.map_or(f64::INFINITY, f64::abs);
        (o.fell_in_clip, !o.contact, !o.goal, o.fell, miss)
    };
    let mut order: Vec<usize> = (0..report.trials.len()).collect();
    order.sort_by(|&a, &b| {
        let (a, b) = (badness(&report.trials[a]), badness(&report.trials[b]));
        (b.0, b.1, b.2, b.3).cmp(&(a.0, a.1, a.2, a.3)).then(b.4.total_cmp(&a.4))
    });
    order.truncate(count);
    order
}

/// Plays the worst `count` shots of a whole report again and draws them.
///
/// # Errors
/// As [`crate::shooting::evaluate`].
pub fn strips(
    setup: &EvalSetup,
    policy: &DriverMaker,
    report: &ShootingReport,
    count: usize,
) -> Result<Vec<Strip>, EvalError> {
    again(setup, policy, report, &worst(report, count))
}

/// Plays the shots with the numbers `wanted` of a whole report again and draws them.
///
/// # Errors
/// As [`crate::shooting::evaluate`].
///
/// # Panics
/// If there is no such shot.
pub fn again(
    setup: &EvalSetup,
    policy: &DriverMaker,
    report: &ShootingReport,
    wanted: &[usize],
) -> Result<Vec<Strip>, EvalError> {
    let options = &report.options;
    let starts: Vec<_> = report.trials.iter().map(|outcome| start_of(&outcome.trial)).collect();
    let dt_s = setup.preset.control_dt_s();
    let (rules, steps) = rules_of(options, dt_s);
    // A shot is filmed for as long as it was followed.
    let longest = wanted.iter().map(|&trial| report.trials[trial].steps as usize).max().unwrap_or(0);
    let films = run_again(setup, policy, &starts, rules, steps.min(longest), wanted, |_| Film::default())?;
    let ball = Some(setup.preset.ball_params.radius_m);
    let strip = |(trial, film): (usize, Film)| Strip {
        trial,
        words: words(&report.trials[trial], options.goal_half_width_m),
        picture: film_strip(&setup.robot, &film, dt_s, ball, options.goal_half_width_m, MOMENTS).halved(),
    };
    Ok(films.into_iter().map(strip).collect())
}

/// The list of a report's strips, after the report's name.
pub(crate) const STRIPS: &str = "worst.json";

/// Writes strips as `STEM_worst_1.png` and so on, and what they show as `STEM_worst.json`.
///
/// # Errors
/// If a file cannot be written.
pub fn write_strips(folder: &Path, stem: &str, strips: &[Strip]) -> Result<(), EvalError> {
    let mut files = Vec::new();
    for (k, strip) in strips.iter().enumerate() {
        let picture = format!("{stem}_worst_{}.png", k + 1);
        strip.picture.save(&folder.join(&picture))?;
        files.push(StripFile { picture, words: strip.words.clone() });
    }
    Ok(write_whole(&folder.join(format!("{stem}_{STRIPS}")), to_json(&files)?.as_bytes())?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shooting::report_tests::{outcome, report};

    #[test]
    fn falls_come_first_then_what_missed_by_most_and_goals_last() {
        let mut report = report();
        let mut fallen = outcome([1.0, 0.0], 0, true, true, 1.0);
        fallen.fell_in_clip = true;
        let clean = |repeat: usize, goal: bool| Outcome {
            fell_in_clip: false,
            fell: false,
            ..outcome([1.0, 0.0], repeat, true, goal, 1.0)
        };
        // Lateral: 0.25 m (1 + repeat).
        let short = Outcome { lateral_m: None, ..clean(0, false) };
        let missed = Outcome { contact: false, ..clean(0, false) };
        report.trials =
            vec![clean(1, true), clean(4, false), clean(3, true), fallen, short, missed, clean(6, false)];
        assert_eq!(worst(&report, 9), [3, 5, 4, 6, 1, 2, 0]);
        assert_eq!(worst(&report, 2), [3, 5]);
    }

    #[test]
    fn a_shot_is_told_in_words() {
        let told = |o: &Outcome| words(o, 1.0);
        let mut o = Outcome { fell_in_clip: false, fell: false, ..outcome([1.0, -0.5], 4, true, false, 1.0) };
        o.motion_name = "kick".to_owned();
        assert_eq!(told(&o), "ball at (1.00, -0.50) m, kick: 0.25 m past the left post");
        o.fell = true;
        assert!(told(&o).ends_with("left post, then fell"), "{}", told(&o));
        let goal = Outcome { goal: true, lateral_m: Some(-0.4), fell: false, ..o.clone() };
        assert!(told(&goal).ends_with(": goal, 0.40 m right of the middle"), "{}", told(&goal));
        let missed = told(&Outcome { contact: false, ..goal.clone() });
        assert!(missed.ends_with(": did not touch the ball"), "{missed}");
        assert!(told(&Outcome { lateral_m: None, goal: false, ..goal }).ends_with(": short of the goal"));
    }
}
