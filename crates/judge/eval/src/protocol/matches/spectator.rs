//! Spectators of matches.

use paid_task::{BelievedBall, EnvSample};

use super::KickOutcome;

/// A moment of a match.
#[derive(Clone, Copy, Debug)]
pub struct Spectacle<'a> {
    /// Number of the match.
    pub number: usize,
    /// The state, world axes.
    pub sample: &'a EnvSample,
    /// Angular velocity of the ball, world axes `[rad/s]`.
    pub ball_spin: [f64; 3],
    /// The robot's estimate of the ball; `None` if it is given the true position.
    pub believed: Option<BelievedBall>,
}

/// Watches matches. They are played on several threads, some of them at the same time.
pub trait Spectator: Sync {
    /// Sees the start and every control step of every match.
    fn see(&self, moment: &Spectacle<'_>);

    /// A kick of match `number` is over; `last`: the match with it.
    fn kicked(&self, number: usize, kick: &KickOutcome, last: bool);
}
