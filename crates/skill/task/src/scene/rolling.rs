//! How a preset's ball slows down while it rolls.

use paid_physics::BallParams;

/// Rate at which a ball that rolls without sliding slows down `[1/s]`, see [`paid_track::roll_decay`].
pub fn roll_decay(ball: &BallParams) -> f64 {
    paid_track::roll_decay(ball.inertia_factor, ball.linear_damping, ball.angular_damping)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_default_ball_is_a_shell() {
        let ball = BallParams { linear_damping: 0.5, angular_damping: 2.0, ..BallParams::default() };
        assert!((roll_decay(&ball) - (0.5 + 4.0 / 3.0) / (5.0 / 3.0)).abs() < 1e-12);
    }
}
