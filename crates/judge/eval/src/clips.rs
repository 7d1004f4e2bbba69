//! Every clip with balls near its own place: which of the kicks can be aimed?
//!
//! A shooting grid lets the ball choose the clip, so it says little about a clip that few places choose.

use std::f64::consts::TAU;
use std::fmt::Write;

use paid_lanes::rng::Rng;
use paid_lanes::stats::mean;
use paid_play::own_place;
use paid_plot::{Table, number};
use paid_task::EnvSample;
use serde::Serialize;

use crate::engine::EngineFacts;
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::metrics::tracking::TrackingErrors;
use crate::policy::DriverMaker;
use crate::shooting::{self, CellScore, Outcome, Placement, ShootingOptions, Trial};
use crate::tracking;
use crate::{EvalError, Setting};

/// Redraws of a ball before a clip counts as having no room for one.
const REDRAWS: usize = 1000;
/// Random stream of the balls.
const STREAM: u32 = 0x5109;

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipsOptions {
    /// Shots of a clip.
    pub trials: usize,
    /// Balls lie in a disc of this radius around the clip's own place `[m]`.
    pub radius_m: f64,
    /// Time limit of a shot `[s]`.
    pub limit_s: f64,
}

impl Default for ClipsOptions {
    /// Forty shots within 0.25 m.
    fn default() -> Self {
        Self { trials: 40, radius_m: 0.25, limit_s: 12.0 }
    }
}

/// One clip's score.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipRow {
    /// Name of the clip.
    pub motion: String,
    /// Its scores; `place` is the clip's own `[m]`.
    pub score: CellScore,
    /// How far off the clip the bodies were, mean over the shots: each from its start to the clip's end, or until it was decided after a
    /// fall.
    pub errors: TrackingErrors,
}

/// Everything.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ClipsReport {
    /// Who simulated.
    pub engine: EngineFacts,
    /// What was run.
    pub options: ClipsOptions,
    /// Every clip that was shot with.
    pub rows: Vec<ClipRow>,
}

/// Runs the shots, static balls, from each clip's own first frame with the goal 5 m ahead. A stopped evaluation reports the shots that
/// ended.
///
/// # Errors
/// As [`shooting::evaluate`].
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ClipsOptions,
) -> Result<ClipsReport, EvalError> {
    let (shots, trials) = plan(setup, options)?;
    let follow = |i: usize| Follow {
        frames: setup.library.facts()[trials[i].motion].frames,
        watch: tracking::Watch::new(setup, trials[i].motion, false),
    };
    let errors = |follow: Follow| follow.watch.errors();
    let outcomes = shooting::outcomes_beside(setup, policy, &shots, &trials, follow, errors)?;
    let rows = setup.library.facts().iter().enumerate().filter_map(|(motion, facts)| {
        let of_clip = || outcomes.iter().filter(|(o, _)| o.trial.motion == motion);
        let shots: Vec<&Outcome> = of_clip().map(|(outcome, _)| outcome).collect();
        let errors: Vec<TrackingErrors> = of_clip().filter_map(|(_, errors)| *errors).collect();
        let mean = |of: fn(&TrackingErrors) -> f64| mean(errors.iter().map(of)).unwrap_or(f64::NAN);
        (!shots.is_empty()).then(|| ClipRow {
            motion: facts.name.clone(),
            score: CellScore::of(Some(own_place(facts)), &shots),
            errors: TrackingErrors {
                mpjpe_mm: mean(|e| e.mpjpe_mm),
                g_mpjpe_mm: mean(|e| e.g_mpjpe_mm),
                velocity_error_mm: mean(|e| e.velocity_error_mm),
            },
        })
    });
    let rows = rows.collect();
    Ok(ClipsReport { engine: setup.engine.facts(&setup.preset), options: options.clone(), rows })
}

/// Follows a clip to its end; the pose that is held afterwards does not count.
struct Follow {
    frames: usize,
    watch: tracking::Watch,
}

impl Observer for Follow {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        // The sample's frame stays at the last one.
        sample.step as usize >= self.frames || self.watch.observe(sample, ended)
    }
}

/// The outcome of every shot.
pub(crate) fn shots(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &ClipsOptions,
) -> Result<Vec<Outcome>, EvalError> {
    let (shots, trials) = plan(setup, options)?;
    shooting::outcomes(setup, policy, &shots, &trials)
}

fn plan(setup: &EvalSetup, options: &ClipsOptions) -> Result<(ShootingOptions, Vec<Trial>), EvalError> {
    let bad = |option, expected: &str, found: String| {
        Err(EvalError::Option { option, expected: expected.to_owned(), found })
    };
    if options.trials == 0 {
        return bad(Setting::Trials, "at least 1", "0".into());
    }
    if !(0.0..=2.0).contains(&options.radius_m) {
        return bad(Setting::Named("radius"), "0 to 2 m", options.radius_m.to_string());
    }
    let placement = Placement::new(setup);
    let shots = ShootingOptions { limit_s: options.limit_s, ..ShootingOptions::default() };
    let goal = [shots.goal_distance_m, 0.0];
    let mut trials = Vec::new();
    for (motion, facts) in setup.library.facts().iter().enumerate() {
        let place = own_place(facts);
        for repeat in 0..options.trials {
            let mut rng = Rng::new(setup.seed, trials.len() as u32, STREAM);
            let ball = (0..REDRAWS)
                .map(|_| {
                    let radius = options.radius_m * rng.unit().sqrt();
                    let (s, c) = (TAU * rng.unit()).sin_cos();
                    [place[0] + radius * c, place[1] + radius * s]
                })
                .find(|ball| !placement.overlaps(motion, *ball));
            let ball = ball.ok_or_else(|| EvalError::Option {
                option: Setting::Named("radius"),
                expected: "positions that leave room for the ball next to the robot".to_owned(),
                found: format!("{} m around {place:?}, the ball of {}", options.radius_m, facts.name),
            })?;
            let (displacement, ball_velocity) = ([0.0; 2], [0.0; 2]);
            trials.push(Trial { place, repeat, displacement, ball, ball_velocity, goal, motion });
        }
    }
    Ok((shots, trials))
}

/// Titles of the table and of the CSV.
const COLUMNS: [&str; 11] = [
    "clip",
    "own place [m]",
    "trials",
    "success",
    "accuracy",
    "contact",
    "a foot first",
    "labeled foot",
    "falls in the clip",
    "MPJPE [mm]",
    "ball [m/s]",
];

impl ClipRow {
    fn cells(&self) -> [String; 11] {
        let share = |share: f64| format!("{:.1}%", 100.0 * share);
        let s = &self.score;
        [
            self.motion.clone(),
            s.place.map_or("-".to_owned(), |[x, y]| format!("{x:.2} {y:.2}")),
            s.success.trials.to_string(),
            share(s.success.share),
            s.accuracy.map_or("-".to_owned(), |v| number(v, 3)),
            share(s.contact.share),
            share(s.foot_contact.share),
            share(s.correct_foot.share),
            share(s.falls_in_clip.share),
            number(self.errors.mpjpe_mm, 0),
            s.ball_speed.map_or("-".to_owned(), |v| number(v, 1)),
        ]
    }
}

impl ClipsReport {
    /// The clip with the least share of goals.
    pub fn worst(&self) -> Option<&ClipRow> {
        self.rows.iter().min_by(|a, b| a.score.success.share.total_cmp(&b.score.success.share))
    }

    /// The rows and the worst as text. Writing to a string cannot fail.
    pub fn table(&self) -> String {
        let o = &self.options;
        let mut table = Table::new(&COLUMNS);
        self.rows.iter().for_each(|row| table.row(row.cells()));
        let mut out = format!(
            "{}; static ball within {} m of each clip's own ball, {} trials per clip{}\n\n{table}",
            self.engine.name,
            o.radius_m,
            o.trials,
            self.engine.knowledge_text()
        );
        if let Some(worst) = self.worst() {
            let _ = writeln!(out, "worst {:.1}% ({})", 100.0 * worst.score.success.share, worst.motion);
        }
        out
    }

    /// One line per clip.
    pub fn csv(&self) -> String {
        let mut out = format!("{},knowledge\n", COLUMNS.join(","));
        for row in &self.rows {
            let cells = row.cells().map(|cell| cell.replace(',', ";")).join(",");
            let _ = writeln!(out, "{cells},{}", self.engine.knowledge_name());
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::EngineChoice;
    use crate::metrics::statistics::Share;
    use crate::shooting::observer_tests::{sample, setup};
    use paid_task::TaskPreset;

    #[test]
    fn the_worst_clip_is_named_in_every_form() {
        let row = |name: &str, goals: &[bool]| {
            let mut score = CellScore::of(Some([1.0, 0.5]), &[]);
            score.success = Share::of(goals.iter().copied());
            ClipRow { motion: name.to_owned(), score, errors: TrackingErrors::default() }
        };
        let report = ClipsReport {
            engine: EngineChoice::Builtin.facts(&TaskPreset::builtin("paper_stage2").expect("built in")),
            options: ClipsOptions::default(),
            rows: vec![row("one", &[true, true]), row("two, hard", &[true, false])],
        };
        assert_eq!(report.worst().map(|row| row.motion.as_str()), Some("two, hard"));
        assert!(report.table().ends_with("worst 50.0% (two, hard)\n"), "{}", report.table());
        let csv = report.csv();
        let fields = |line: &str| line.split(',').count();
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines.len() == 3 && lines.iter().all(|line| fields(line) == fields(lines[0])), "{csv}");
    }

    #[test]
    fn the_pose_that_is_held_after_the_clip_is_no_error() {
        let setup = setup();
        let frames = setup.library.facts()[0].frames;
        let hand =
            setup.robot.body_index(setup.spec.tracked_bodies.last().expect("a body")).expect("of the robot");
        let mut follow = Follow { frames, watch: tracking::Watch::new(&setup, 0, false) };
        for step in 0..10 {
            let mut sample = sample(&setup, frames, step);
            // 28 mm in both frames of the clip, then 1 m.
            sample.bodies[hand].pos[2] += if step < 2 { 0.028 } else { 1.0 };
            assert_eq!(follow.observe(&sample, None), step >= 2, "step {step}");
        }
        // One of 14 bodies: 2 mm.
        let errors = follow.watch.errors().expect("two frames");
        assert!((errors.mpjpe_mm - 2.0).abs() < 1e-9 && (errors.g_mpjpe_mm - 2.0).abs() < 1e-9, "{errors:?}");
    }
}
