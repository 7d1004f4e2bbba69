//! One episode of a policy: what `paid eval film` and `paid play --policy` watch.

use paid_eval::episodes::{Observer, run_episodes};
use paid_eval::shooting::{self, Placement, ShootingOptions};
use paid_task::{EvalOptions, InitialState};

use super::engine::positive;
use super::subject::Subject;
use crate::failure::Failure;

/// How the episode begins and when it ends.
#[derive(Debug, clap::Args)]
pub struct Shot {
    /// Ball place x,y in the robot's first pose [m]; the nearest motion is chosen [default: the motion's own].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, requires = "policy")]
    pub ball: Option<[f64; 2]>,
    /// Ball velocity x,y [m/s].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, default_value = "0,0", requires = "policy")]
    pub velocity: [f64; 2],
    /// Time limit [s].
    #[arg(long, value_name = "S", value_parser = positive, default_value = "10", requires = "policy")]
    pub limit: f64,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() && text.matches(',').count() == 1 => Ok([x, y]),
        _ => Err(format!("expected two numbers X,Y, found '{text}'")),
    }
}

/// An episode that was watched.
pub struct Watched<O> {
    /// What the observer kept.
    pub seen: O,
    /// Index of the motion that was followed.
    pub motion: usize,
    /// Half the goal's width [m].
    pub goal_half_width_m: f64,
}

impl Shot {
    /// Plays the episode with the given motion, or else with the nearest to the ball, or else with the first. `reward_terms`: the
    /// observer sees them.
    ///
    /// # Errors
    /// A motion or a ball that the subject does not have, a policy that does not fit.
    pub fn watch<O: Observer>(
        &self,
        subject: &Subject,
        motion: Option<usize>,
        reward_terms: bool,
        observer: impl Fn(usize) -> O + Sync,
    ) -> Result<Watched<O>, Failure> {
        if self.ball.is_some() || self.velocity != [0.0; 2] {
            subject.needs_ball()?;
        }
        let setup = &subject.setup;
        let motion = motion
            .unwrap_or_else(|| self.ball.map_or(0, |ball| Placement::new(setup).motion(ball, self.velocity)));
        let start = InitialState {
            ball_xy: self.ball,
            ball_velocity: self.velocity,
            ..InitialState::nominal(motion)
        };
        let limits = ShootingOptions { limit_s: self.limit, ..ShootingOptions::default() };
        let (control, steps) = shooting::control_of(&limits, setup.preset.control_dt_s());
        let control = EvalOptions { reward_terms, ..control };
        let mut seen = run_episodes(setup, &*subject.maker, &[start], control, steps, |_| observer(motion))
            .map_err(Failure::input)?;
        match seen.pop() {
            Some((_, seen)) => Ok(Watched { seen, motion, goal_half_width_m: limits.goal_half_width_m }),
            None => Err(Failure::input("the episode was stopped before its end")),
        }
    }
}
