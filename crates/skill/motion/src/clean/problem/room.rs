//! Room inside the limits, so that a limit that is nearly kept is kept.

/// Joint from the end of its range `[rad]`.
pub(super) const RANGE: f64 = 0.003;
/// Share of the speed limit; the check warns above 0.9.
pub(super) const SPEED: f64 = 0.86;
/// Change of a joint's velocity in a frame as a share of its limit; the check warns above 0.5.
pub(super) const JUMP: f64 = 0.42;
/// Height of a swinging foot above the floor, and the highest that the lower foot flies `[m]`.
pub(super) const CLEAR: f64 = 0.004;
pub(super) const HIGH: f64 = 0.02;
/// Parts of the robot from each other `[m]`.
pub(super) const APART: f64 = 0.004;
/// Force that holds along the floor as a share of that upwards; soles are sure to give 0.8.
pub(super) const FRICTION: f64 = 0.7;
/// Least force of the floor while a foot stands, as a share of the weight.
pub(super) const WEIGHT: f64 = 0.15;
