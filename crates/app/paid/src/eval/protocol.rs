//! What is shot at: options of the shooting protocol.

use clap::ValueEnum;
use paid_eval::shooting::{Grid, ROLLING_SPEED, ShootingOptions, Variant};

use super::engine::positive;
use crate::failure::Failure;

/// How the ball moves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Ball {
    /// It lies still.
    Static,
    /// It rolls at 0.1 to 0.3 m/s in a random direction.
    Rolling,
    /// First static, then rolling, and the paper's four panels in one figure.
    Both,
}

/// Options of the shooting protocol.
#[derive(Clone, Debug, clap::Args)]
#[command(next_help_heading = "Shots")]
pub struct ProtocolArgs {
    /// How the ball moves [default: static].
    #[arg(long, value_enum)]
    ball: Option<Ball>,
    /// Same as --ball rolling.
    #[arg(long, hide_short_help = true, conflicts_with = "ball")]
    rolling: bool,
    /// Slowest and fastest rolling ball [m/s]; implies --ball rolling.
    #[arg(long, hide_short_help = true, value_name = "M/S", num_args = 2)]
    speed: Option<Vec<f64>>,
    /// Place ball and goal in the robot's frame, as the public evaluation does.
    ///
    /// Positions are then measured from the robot's first pose instead of the world, so displacing the robot changes nothing.
    #[arg(long)]
    robot_frame: bool,
    /// Only the effective workspace, [0.5, 2] x [-1, 1] m: 63 positions.
    #[arg(long)]
    effective: bool,
    /// The paper's whole grid, [0.5, 3] x [-1.5, 1.5] m: 143 positions.
    #[arg(long, conflicts_with = "effective")]
    whole_grid: bool,
    /// Displace the robot's start by up to this distance [m].
    #[arg(long, hide_short_help = true, default_value_t = 0.5)]
    start_radius: f64,
    /// Move each ball from its position by up to this much in x and in y [m].
    #[arg(long, hide_short_help = true, value_name = "M", default_value_t = 0.0)]
    scatter: f64,
    /// Width of the goal [m].
    #[arg(long, hide_short_help = true, default_value_t = 2.0, value_parser = positive)]
    goal_width: f64,
    /// Distance of the goal ahead of the robot [m].
    #[arg(long, hide_short_help = true, default_value_t = 5.0, value_parser = positive)]
    goal_distance: f64,
    /// Time limit of a trial [s].
    #[arg(long, hide_short_help = true, default_value_t = 12.0)]
    limit: f64,
    /// Keep simulating for this long after the kick, and count falls [s].
    ///
    /// The clip's last frame is held meanwhile.
    #[arg(long, hide_short_help = true, value_name = "S", value_parser = positive)]
    after_s: Option<f64>,
}

impl ProtocolArgs {
    /// The options of each kind of ball that was asked for, on `usual_grid` unless another was asked for.
    ///
    /// # Errors
    /// If a speed is given to a ball that lies still.
    pub fn options(&self, trials: usize, usual_grid: Grid) -> Result<Vec<ShootingOptions>, Failure> {
        let speed = match self.speed.as_deref() {
            Some([slow, fast]) => [*slow, *fast],
            _ => ROLLING_SPEED,
        };
        let rolls = self.rolling || self.speed.is_some();
        let kinds: &[Option<[f64; 2]>] = match self.ball {
            Some(Ball::Static) if self.speed.is_some() => {
                return Err(Failure::input("--speed: expected a ball that rolls, found --ball static"));
            }
            Some(Ball::Static) => &[None],
            None if !rolls => &[None],
            None | Some(Ball::Rolling) => &[Some(speed)],
            Some(Ball::Both) => &[None, Some(speed)],
        };
        let grid = match (self.effective, self.whole_grid) {
            (true, _) => Grid::EFFECTIVE,
            (_, true) => Grid::WHOLE,
            _ => usual_grid,
        };
        let of = |rolling: &Option<[f64; 2]>| ShootingOptions {
            grid,
            trials,
            variant: if self.robot_frame { Variant::Robot } else { Variant::World },
            start_radius_m: self.start_radius,
            scatter_m: self.scatter,
            rolling: *rolling,
            goal_distance_m: self.goal_distance,
            goal_half_width_m: 0.5 * self.goal_width,
            limit_s: self.limit,
            after_s: self.after_s,
        };
        Ok(kinds.iter().map(of).collect())
    }
}
