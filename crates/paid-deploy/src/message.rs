//! What travels between robot, perception and runtime.

use serde::{Deserialize, Serialize};

/// A picture that the ball detector has looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sighting {
    /// When it was taken, on the clock of the runtime `[us]`.
    pub captured_us: u64,
    /// Center of the ball in the frame of the body that carries the camera (torso) `[m]`; `None`: no ball in it.
    pub ball: Option<[f64; 3]>,
    /// Expected standard deviation on each axis `[m]`.
    pub deviation_m: f64,
}

/// A pose from odometry. Its frame is fixed to the ground, z up, with origin and heading of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryPose {
    /// When the robot was there, on the clock of the runtime `[us]`.
    pub stamp_us: u64,
    /// Origin of the pelvis `[m]`.
    pub position: [f64; 3],
    /// Pelvis in odometry's frame: w, x, y, z.
    pub quaternion: [f64; 4],
}

/// One message on the link.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Packet {
    /// [`crate::wire::LowState`] in CDR, from the robot.
    LowState(Vec<u8>),
    /// [`crate::wire::LowCmd`] in CDR, to the robot.
    LowCmd(Vec<u8>),
    /// A command to the robot that is not this runtime's.
    OthersCommand,
    /// A picture.
    Sighting(Sighting),
    /// A pose.
    Odometry(OdometryPose),
    /// Center of the goal (x, y), odometry's frame `[m]`.
    Goal([f64; 2]),
    /// Charge of the battery in percent.
    Battery(f64),
}
