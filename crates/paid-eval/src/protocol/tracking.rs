//! How well the policy follows each motion (paper, section IV-A).

mod observer;
mod report;
mod score;

use paid_task::{EvalOptions, ForcedStart};

use crate::EvalError;
use crate::episodes::{Arena, run_episodes};
use crate::policy::PolicyMaker;
use observer::Watch;

pub use report::TrackingReport;
pub use score::{ClipScore, MeanScore, PAPER_ROWS, PaperRow, RunScore, SetScore};

/// What to run.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackingOptions {
    /// Perturbed starts a clip, besides one exact start.
    pub starts: usize,
    /// Set of each motion of the library (`standard`, `stylized`, ...): the paper's rows are per set.
    pub sets: Vec<String>,
    /// True: an episode ends where training would end it. False: only a fall ends it, so that figures of policies that drift
    /// cover the whole motion.
    pub limits: bool,
}

/// Runs every motion from its first frame: once exactly, and `starts` times with the preset's reset noise. Observation noise, pushes and randomisation are off, so exact starts need no repetition.
///
/// # Errors
/// As [`run_episodes`], or if the sets do not match the library.
pub fn evaluate(
    arena: &Arena,
    policy: &PolicyMaker,
    options: &TrackingOptions,
) -> Result<TrackingReport, EvalError> {
    let motions = arena.library.len();
    if options.sets.len() != motions {
        return Err(EvalError::Option {
            option: "sets",
            expected: format!("one for each of {motions} motions"),
            found: options.sets.len().to_string(),
        });
    }
    let mut starts = Vec::new();
    for motion in 0..motions {
        starts.push(ForcedStart::nominal(motion));
        for _ in 0..options.starts {
            starts.push(ForcedStart { noise: true, ..ForcedStart::nominal(motion) });
        }
    }
    // The time limit must not cut a long motion short.
    let longest = arena.library.facts().iter().map(|f| f.frames).max().unwrap_or(0) + 1;
    let control = EvalOptions {
        hold_last_frame: false,
        end_on_failure: options.limits,
        max_steps: u32::try_from(longest).ok(),
        ..EvalOptions::default()
    };
    let watches = run_episodes(arena, policy, &starts, control, longest, |trial| {
        Watch::new(arena, starts[trial].motion, !options.limits)
    })?;
    let runs: Vec<RunScore> = watches.iter().map(|(i, watch)| watch.score(!starts[*i].noise)).collect();
    Ok(TrackingReport::new(arena, options, runs))
}
