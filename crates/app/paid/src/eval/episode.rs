//! Arguments of one episode: what `paid eval film` and `paid play --policy` watch.

use paid_eval::shot::Shot;

use super::engine::positive;

/// How the episode begins and when it ends.
#[derive(Debug, clap::Args)]
pub struct ShotArgs {
    /// Ball x,y in the robot's first pose [m] [default: the motion's own].
    ///
    /// The nearest motion is chosen.
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, requires = "policy")]
    ball: Option<[f64; 2]>,
    /// Ball velocity x,y [m/s].
    #[arg(long, value_name = "X,Y", value_parser = pair, allow_hyphen_values = true, default_value = "0,0", requires = "policy")]
    velocity: [f64; 2],
    /// Time limit [s].
    #[arg(long, hide_short_help = true, value_name = "S", value_parser = positive, default_value = "10", requires = "policy")]
    limit: f64,
}

fn pair(text: &str) -> Result<[f64; 2], String> {
    let numbers: Vec<f64> = text.split(',').filter_map(|t| t.trim().parse().ok()).collect();
    match numbers[..] {
        [x, y] if x.is_finite() && y.is_finite() && text.matches(',').count() == 1 => Ok([x, y]),
        _ => Err(format!("expected two numbers X,Y, found '{text}'")),
    }
}

impl ShotArgs {
    /// The episode with the given motion, or else with the nearest to the ball, or else with the first.
    pub fn shot(&self, motion: Option<usize>) -> Shot {
        Shot { ball: self.ball, velocity: self.velocity, limit_s: self.limit, motion, reward_terms: false }
    }
}
