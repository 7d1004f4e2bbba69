//! How well the policy follows each motion (paper, section IV-A).

mod observer;
mod report;
mod score;

use paid_task::{AtMotionEnd, EpisodeRules, InitialState, OnFailure, TimeLimit};

use crate::episodes::{EvalSetup, run_episodes};
use crate::policy::DriverMaker;
use crate::share::run_shared;
use crate::trace::{Trace, Traced};
use crate::{EvalError, Setting};
pub(crate) use observer::Watch;

pub use report::TrackingReport;
pub use score::{BodyScore, ClipScore, MeanScore, PAPER_ROWS, PaperRow, RunScore, SetScore};

/// What to run.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingOptions {
    /// Perturbed starts per clip, besides one exact start.
    pub starts: usize,
    /// Set of each motion of the library (`standard`, `stylized`, ...): the paper's rows are per set.
    pub sets: Vec<String>,
    /// True: an episode ends where training would end it. False: only a fall ends it, so that figures of policies that drift
    /// cover the whole motion.
    pub limits: bool,
}

/// Runs every motion from its first frame: once exactly, and `starts` times with the preset's reset noise. Observation noise, pushes and randomization are off, so exact starts need no repetition.
///
/// # Errors
/// As [`run_episodes`], or if the sets do not match the library.
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &TrackingOptions,
) -> Result<TrackingReport, EvalError> {
    let Course { starts, rules, longest } = Course::new(setup, options)?;
    let watch = |i: usize| Watch::new(setup, starts[i].motion, !options.limits);
    let score = |i: usize, watch: Watch| watch.score(!starts[i].noise);
    let runs = run_shared(setup, policy, &starts, rules, longest, watch, score)?;
    Ok(TrackingReport::new(setup, options, runs.into_iter().map(|(_, run)| run).collect()))
}

/// As [`evaluate`], with the number and the trace of every run in the report's order.
///
/// # Errors
/// As [`evaluate`].
pub fn evaluate_traced(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &TrackingOptions,
) -> Result<(TrackingReport, Vec<(usize, Trace)>), EvalError> {
    let ball = setup.preset.scene.ball;
    let Course { starts, rules, longest } = Course::new(setup, options)?;
    let watch = |i: usize| Traced {
        watch: Watch::new(setup, starts[i].motion, !options.limits),
        trace: Trace::default(),
        ball,
    };
    let (mut runs, mut traces) = (Vec::new(), Vec::new());
    for (i, Traced { watch, trace, .. }) in run_episodes(setup, policy, &starts, rules, longest, watch)? {
        runs.push(watch.score(!starts[i].noise));
        traces.push((i, trace));
    }
    Ok((TrackingReport::new(setup, options, runs), traces))
}

/// What is run: for each motion an exact start, then those with reset noise.
struct Course {
    starts: Vec<InitialState>,
    rules: EpisodeRules,
    /// Control steps of the longest motion, and one.
    longest: usize,
}

impl Course {
    fn new(setup: &EvalSetup, options: &TrackingOptions) -> Result<Self, EvalError> {
        let motions = setup.library.len();
        if options.sets.len() != motions {
            return Err(EvalError::Option {
                option: Setting::Named("sets"),
                expected: format!("one for each of {motions} motions"),
                found: options.sets.len().to_string(),
            });
        }
        let mut starts = Vec::new();
        for motion in 0..motions {
            starts.push(InitialState::nominal(motion));
            for _ in 0..options.starts {
                starts.push(InitialState { noise: true, ..InitialState::nominal(motion) });
            }
        }
        // The time limit must not cut a long motion short.
        let longest = setup.library.facts().iter().map(|f| f.frames).max().unwrap_or(0) + 1;
        let rules = EpisodeRules {
            at_motion_end: AtMotionEnd::End,
            on_failure: if options.limits { OnFailure::End } else { OnFailure::Continue },
            time_limit: TimeLimit::Steps(u32::try_from(longest).unwrap_or(u32::MAX)),
            ..EpisodeRules::evaluation()
        };
        Ok(Self { starts, rules, longest })
    }
}
