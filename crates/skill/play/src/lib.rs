//! How a policy is played, in training, in evaluations and on a robot: which motion it follows for a ball, the frames of that motion, and
//! what it is shown of ball and goal.
//!
//! Nothing here knows a trainer or a simulator. Begin with [`PolicyFile`], which reads a policy, [`ReferenceLibrary`], its motions, [`motion_for`],
//! the choice among them, and [`BelievedScene`], what the policy is shown.

mod after_strike;
mod contract;
mod error;
mod library;
mod mirror;
mod motion;
mod own_place;
mod policy_file;
mod preset;
mod scene;

pub use after_strike::{AfterStrike, AfterStrikePreset, AfterStrikeTimes, ShownAfterStrike};
pub use contract::{ACTION, COMMAND, policy_contract, robot_contract};
pub use error::PlayError;
pub use library::{
    FrameLayout, KickTimes, MotionFacts, ReferenceClip, ReferenceLibrary, STANDING_BALL_M, body_index,
    followed_bodies,
};
pub use mirror::{policy_mirrors, sides};
pub use motion::{
    RollingBall, from_start_frame, motion_for, nearest_motion, nominal_ball, own_place, turned,
};
pub use own_place::OwnPlace;
pub use policy_file::{NO_PRESET, POLICY_FILE, PRESET_FILE, PolicyFile, is_onnx, load_robot};
pub use preset::{
    PlayPreset, PlayedBall, PlayedObservations, PlayedPlacement, PlayedRandomization, PlayedScene,
};
pub use scene::{BelievedScene, SceneMemory};
