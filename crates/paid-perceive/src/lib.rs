//! What it takes to know where ball and goal are: camera geometry, the noise of a seen position, prediction of a rolling ball, and
//! what is shown of the ball after the strike.
//!
//! Everything is written over [`paid_lanes::Real`]: one environment per SIMD lane in training, plain `f64` elsewhere.
//!
//! ```
//! use paid_lanes::Vec3;
//! use paid_perceive::{effective_time, predicted_displacement, roll_decay};
//!
//! // A thin shell that rolls away at 0.5 m/s: where is it in 1.5 seconds?
//! let decay = roll_decay(2.0 / 3.0, 0.01, 4.28);
//! let time: f64 = effective_time(1.5, decay);
//! let moved = predicted_displacement(Vec3([0.5, 0.0, 0.0]), time);
//! assert!((moved.x() - 0.27).abs() < 0.01);
//! ```

mod after_strike;
mod camera;
mod noise;
mod rolling;

pub use after_strike::{AfterStrike, AfterStrikeTimes};
pub use camera::Camera;
pub use noise::PositionNoise;
pub use rolling::{effective_time, predicted_displacement, roll_decay};
