//! What a ball tracker is given, and its estimate.

use paid_lanes::Real;

/// A detection of the ball in an image.
#[derive(Clone, Copy, Debug)]
pub struct Measurement<V: Real> {
    /// Center of the ball (x, y), odometry frame at capture time `[m]`.
    pub position: [V; 2],
    /// Variance of the position on each axis `[m^2]`.
    pub variance: V,
    /// Time since the capture `[s]`.
    pub age_s: V,
    /// Where there is a detection at all.
    pub seen: V::Mask,
}

/// How the ball moves, as far as the robot knows.
#[derive(Clone, Copy, Debug)]
pub struct Rolling<V> {
    /// Rate at which it slows down `[1/s]`, see [`crate::roll_decay`].
    pub decay: V,
    /// Time until the robot strikes, negative afterwards `[s]`.
    pub to_strike_s: V,
}

/// Position and velocity with their covariance on each axis: the Kalman filter's state.
#[derive(Clone, Copy, Debug)]
pub struct BallEstimate<V> {
    /// Center of the ball (x, y), odometry frame `[m]`.
    pub position: [V; 2],
    /// Its velocity, same axes `[m/s]`.
    pub velocity: [V; 2],
    /// Variance of the position `[m^2]`, covariance of position and velocity `[m^2/s]`, variance of the velocity `[m^2/s^2]`; the
    /// axes are independent.
    pub covariance: [V; 3],
}

/// What the tracker believes now.
#[derive(Clone, Copy, Debug)]
pub struct Belief<V: Real> {
    /// The mean of resting and rolling by their probabilities; its covariance is that of a ball that may roll.
    pub ball: BallEstimate<V>,
    /// Probability that the ball lies still.
    pub rest: V,
    /// Time since the capture of the last image that was accepted `[s]`.
    pub age_s: V,
    /// Where the ball was ever seen.
    pub known: V::Mask,
}
