//! Deviations that cost a square of one. Those of soft goals are wide, those of conditions narrow.

/// Base from the original `[m]`: along the floor and up.
pub(super) const BASE: [f64; 3] = [0.08, 0.08, 0.04];
/// Base from the original `[rad]`.
pub(super) const TILT: f64 = 0.10;
/// Joint from the original `[rad]`.
pub(super) const JOINT: f64 = 0.25;
/// Acceleration of those differences `[m/s^2, rad/s^2]`.
pub(super) const BASE_ACC: f64 = 3.0;
pub(super) const TILT_ACC: f64 = 12.0;
pub(super) const JOINT_ACC: f64 = 30.0;
/// A foot in the air, the kicking foot near the kick, and a hand from the original `[m]`.
pub(super) const SWING: f64 = 0.03;
pub(super) const STRIKE: f64 = 0.006;
pub(super) const HAND: f64 = 0.06;
/// A foot in the air, orientation `[rad]`.
pub(super) const SWING_TURN: f64 = 0.25;
/// A foot that stands, from its foothold `[m, rad]`.
pub(super) const HOLD: f64 = 0.003;
pub(super) const HOLD_TURN: f64 = 0.012;
/// Speed of a foot that stands `[m/s]`.
pub(super) const SLIDE: f64 = 0.012;
/// On heel or toes alone `[rad]`.
pub(super) const ROLL_TURN: f64 = 0.1;
/// Conditions: angle beyond the range `[rad]`, shares of speed limit and torque, depth `[m]`.
pub(super) const RANGE: f64 = 0.002;
pub(super) const SPEED: f64 = 0.01;
pub(super) const TORQUE: f64 = 0.04;
pub(super) const DEPTH: f64 = 0.003;
pub(super) const APART: f64 = 0.001;
/// Pressure outside of its margin `[m]`; force as a share of the weight.
pub(super) const PRESSURE: f64 = 0.002;
pub(super) const FORCE: f64 = 0.03;
/// Force in the air as a share of the weight.
pub(super) const FLIGHT: f64 = 0.25;
/// Speed at the two ends `[m/s, rad/s]`.
pub(super) const REST: f64 = 0.01;
