//! What it takes to know where ball and goal are: camera, odometry, ball tracker, prediction of a rolling ball.
//!
//! Everything is written over [`paid_lanes::Real`]: one environment per SIMD lane in training, plain `f64` on a robot. A robot uses
//! [`BallTracker`] with its own images and its own odometry; [`Eyes`] stand in for both in simulation.
//!
//! ```
//! use paid_lanes::Vec3;
//! use paid_track::{effective_time, predicted_displacement, roll_decay};
//!
//! // A thin shell that rolls away at 0.5 m/s: where is it in 1.5 seconds?
//! let decay = roll_decay(2.0 / 3.0, 0.01, 4.28);
//! let time: f64 = effective_time(1.5, decay);
//! let moved = predicted_displacement(Vec3([0.5, 0.0, 0.0]), time);
//! assert!((moved.x() - 0.27).abs() < 0.01);
//! ```
//!
//! Images of a ball that lies 1 m ahead, 60 ms late, ten in a second:
//!
//! ```
//! use paid_track::{BallTracker, Measurement, Rolling, TrackerPreset};
//!
//! let (preset, mut tracker) = (TrackerPreset::default(), BallTracker::<f64>::new());
//! let rolling = Rolling { decay: 0.0, to_strike_s: 5.0 };
//! for k in 0..20 {
//!     let error = if k % 2 == 0 { 0.02 } else { -0.02 };
//!     let image = Measurement { position: [1.0 + error, 0.0], variance: 4e-4, age_s: 0.06, seen: true };
//!     tracker.advance(0.1, 0.06, &rolling, &preset);
//!     tracker.fuse(&image, &rolling, &preset);
//! }
//! let belief = tracker.belief(&rolling, &preset);
//! assert!((belief.ball.position[0] - 1.0).abs() < 0.01 && belief.rest > 0.9);
//! ```

mod belief;
mod camera;
mod error;
mod eyes;
mod eyes_preset;
mod first_look;
mod memory;
mod memory_preset;
mod noise;
mod odometry;
mod pose;
mod rolling;
mod tracker;
mod tracker_preset;

pub use belief::{BallEstimate, Belief, Measurement, Rolling};
pub use camera::{Camera, CameraPreset};
pub use error::ValueError;
pub use eyes::{BodyPose, Eyes, EyesNumbers, EyesStart, TrueScene};
pub use eyes_preset::{EyesDraw, EyesPreset};
pub use first_look::BallAtStart;
pub use memory::{BallMemory, BallState, Candidate, Glance, TrackedBall};
pub use memory_preset::MemoryPreset;
pub use noise::PositionNoise;
pub use odometry::{OdometryDrift, OdometryPreset};
pub use pose::{Pose, PoseBuffer, PoseGap, StampedPose, turned};
pub use rolling::{effective_time, predicted_displacement, roll_decay};
pub use tracker::BallTracker;
pub use tracker_preset::TrackerPreset;
