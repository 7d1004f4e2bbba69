//! Matches: kick after kick, and the robot is never reset. It stands still, a new ball appears in front of it, and it continues from there.

mod draw;
mod observer;
mod report;
mod spectator;

use std::cell::RefCell;

use draw::{Draw, first_start};
use observer::Player;
use paid_plot::Film;
use paid_task::{EpisodeRules, TimeLimit};
use serde::Serialize;

use crate::episodes::EvalSetup;
use crate::policy::DriverMaker;
use crate::share::run_shared;
use crate::shooting::Grid;
use crate::{EvalError, Setting};

pub use draw::MatchBall;
pub use report::{KickOutcome, MatchOutcome, MatchReport, MatchTotal};
pub use spectator::{Spectacle, Spectator};

/// What to run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct MatchOptions {
    /// Kicks of a match without a fall.
    pub kicks: usize,
    /// Number of matches.
    pub matches: usize,
    /// Balls lie anywhere in the rectangle of this grid, measured from the robot's anchor along its heading.
    pub workspace: Grid,
    /// Speed range of a rolling ball `[m/s]` in any direction; `None`: the ball lies still.
    pub rolling: Option<[f64; 2]>,
    /// Distance of the goal's center `[m]`.
    pub goal_distance_m: f64,
    /// The goal's center is up to so far off straight ahead `[degrees]`.
    pub goal_bearing_deg: f64,
    /// Half of the goal's width `[m]`.
    pub goal_half_width_m: f64,
    /// A robot stands still whose base is slower `[m/s]` ...
    pub still_base_m_s: f64,
    /// ... and whose joints' speeds have a root mean square below this `[rad/s]` ...
    pub still_joint_rad_s: f64,
    /// ... for this long `[s]`.
    pub still_s: f64,
    /// The next ball comes at the latest this long after the clip's end `[s]`, whether or not the robot stands still and the last ball has
    /// reached the goal plane or not.
    pub patience_s: f64,
}

impl Default for MatchOptions {
    /// Ten matches of fifty static balls.
    fn default() -> Self {
        Self {
            kicks: 50,
            matches: 10,
            workspace: Grid::EFFECTIVE,
            rolling: None,
            goal_distance_m: 5.0,
            goal_bearing_deg: 10.0,
            goal_half_width_m: 1.0,
            still_base_m_s: 0.1,
            still_joint_rad_s: 0.5,
            still_s: 0.5,
            patience_s: 5.0,
        }
    }
}

impl MatchOptions {
    fn check(&self) -> Result<(), EvalError> {
        for (name, value) in [("kicks", self.kicks), ("matches", self.matches)] {
            if !(1..=10_000).contains(&value) {
                let (expected, found) = ("1 to 10000".to_owned(), value.to_string());
                return Err(EvalError::Option { option: Setting::Named(name), expected, found });
            }
        }
        Ok(())
    }
}

/// Who sees the matches while they are played.
#[derive(Clone, Copy, Default)]
pub struct Audience<'a> {
    /// Number of kicks of the first match that are filmed, every fourth control step.
    pub filmed: usize,
    /// Watches; the matches wait for it.
    pub spectator: Option<&'a dyn Spectator>,
}

/// Runs the matches. A run that was stopped reports the matches that ended. What the audience sees changes nothing.
///
/// # Errors
/// As [`run_shared`], or if an option makes no sense, or no place of the workspace has room for a ball.
pub fn evaluate(
    setup: &EvalSetup,
    policy: &DriverMaker,
    options: &MatchOptions,
    audience: Audience<'_>,
) -> Result<(MatchReport, Vec<Film>), EvalError> {
    options.check()?;
    let mut draws: Vec<Draw> = (0..options.matches).map(|i| Draw::new(setup, options, i)).collect();
    let starts = draws.iter_mut().map(first_start).collect::<Result<Vec<_>, _>>()?;
    let facts = setup.library.facts();
    let dt_s = setup.preset.control_dt_s();
    let longest = facts.iter().map(|f| f.frames).max().unwrap_or(0);
    let wait = (options.patience_s / dt_s).round() as usize;
    let steps = options.kicks * (longest + wait + 1);
    let time_limit = TimeLimit::Steps(u32::MAX);
    let rules = EpisodeRules { time_limit, ..EpisodeRules::evaluation() };
    let observer = |i: usize| {
        let filmed = if i == 0 { audience.filmed } else { 0 };
        let seen_by = Audience { filmed, ..audience };
        Player::new(setup, options, draws[i].clone(), &starts[i], seen_by)
    };
    let films = RefCell::new(Vec::new());
    let outcome = |number: usize, player: Player<'_>| {
        let (outcome, film) = player.finish(number);
        films.borrow_mut().extend(film);
        outcome
    };
    let matches = run_shared(setup, policy, &starts, rules, steps, observer, outcome)?;
    let (matches, films) = (matches.into_iter().map(|(_, outcome)| outcome).collect(), films.into_inner());
    Ok((MatchReport::new(setup.engine.facts(&setup.preset), options, matches), films))
}
