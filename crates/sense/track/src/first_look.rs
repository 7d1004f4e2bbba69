//! What the robot knows of the ball before it begins.

use paid_lanes::rng::Rng;

use crate::{BallTracker, EyesDraw, EyesPreset, Measurement, Rolling};

/// The ball at the moment when the robot begins, seen from the robot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallAtStart {
    /// Center (x, y) relative to the robot, in any horizontal axes `[m]`.
    pub place: [f64; 2],
    /// Velocity in the same axes `[m/s]`.
    pub velocity: [f64; 2],
    /// Rate at which it slows down `[1/s]`.
    pub decay: f64,
    /// Height of the robot's base above the ball `[m]`: the noise grows with the distance.
    pub height_m: f64,
}

impl EyesDraw {
    /// The rate at which the robot believes the ball to slow down `[1/s]`.
    pub fn decay(&self, ball: &BallAtStart) -> f64 {
        self.decay_scale * ball.decay
    }

    /// The ball's motion before the robot has begun: no strike is near.
    pub fn before_start(&self, ball: &BallAtStart) -> Rolling<f64> {
        Rolling { decay: self.decay(ball), to_strike_s: f64::INFINITY }
    }

    /// Looks at the ball until the robot begins: [`EyesPreset::first_look`] images, the last of which has just arrived. The robot stands
    /// and turns to the ball, so that all of them show it; nothing else is taken for it. In the axes of `ball`.
    pub fn first_look(&self, preset: &EyesPreset, ball: &BallAtStart, rng: &mut Rng) -> BallTracker<f64> {
        let ([x, y], [vx, vy]) = (ball.place, ball.velocity);
        let rolling = self.before_start(ball);
        let mut tracker = BallTracker::<f64>::new();
        for k in (0..preset.first_look).rev() {
            let age_s = self.latency_s + k as f64 * self.period_s;
            // How far it has rolled since; backward in time it was faster.
            let way = if ball.decay * age_s < 1e-9 {
                age_s
            } else {
                ((ball.decay * age_s).exp() - 1.0) / ball.decay
            };
            let place = [x - way * vx, y - way * vy];
            let speed = vx.hypot(vy) * (ball.decay * age_s).exp();
            let distance = (place[0] * place[0] + place[1] * place[1] + ball.height_m * ball.height_m).sqrt();
            let expected: f64 = preset.noise().deviation(speed, distance);
            let sigma = self.noise_scale * expected;
            let position = place.map(|p| p + sigma * rng.normal());
            // The age is counted from the image's arrival; the clock moves on with the next image.
            let picture =
                Measurement { position, variance: expected * expected, age_s: self.latency_s, seen: true };
            tracker.advance(self.period_s, self.latency_s, &rolling, &preset.tracker);
            tracker.fuse(&picture, &rolling, &preset.tracker);
        }
        tracker
    }
}
