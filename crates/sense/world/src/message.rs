//! What reaches perception.

use paid_lanes::{Quat, Vec3};
use paid_track::StampedPose;
use paid_vision::{ColorImage, DepthImage, Intrinsics, PixelBox};

/// Time in seconds, for stamps that are whole nanoseconds.
pub fn seconds(ns: u64) -> f64 {
    ns as f64 * 1e-9
}

/// A color image with the depth image that is aligned to it.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureMessage {
    /// The middle of its exposure `[ns]`.
    pub captured_ns: u64,
    /// The color image.
    pub color: ColorImage,
    /// The depth image, if there is one.
    pub depth: Option<DepthImage>,
    /// The camera's intrinsics.
    pub intrinsics: Intrinsics,
    /// Boxes of another detector that came with the image; `None`: perception runs its own.
    pub boxes: Option<Vec<PixelBox>>,
}

/// A sample of the LiDAR's inertial sensor, in its own frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImuMessage {
    /// When it was taken `[ns]`.
    pub stamp_ns: u64,
    /// Angular velocity `[rad/s]`.
    pub gyro: [f64; 3],
    /// Specific force `[m/s^2]`.
    pub accel: [f64; 3],
}

/// A scan of the LiDAR, in its own frame.
#[derive(Clone, Debug, PartialEq)]
pub struct ScanMessage {
    /// Its begin `[ns]`.
    pub start_ns: u64,
    /// Its end `[ns]`.
    pub end_ns: u64,
    /// Place `[m]` and time since the begin `[s]` of every return.
    pub points: Vec<[f64; 4]>,
}

/// The torso in the frame of any other odometry.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PoseMessage {
    /// When it was there `[ns]`.
    pub stamp_ns: u64,
    /// Place `[m]`.
    pub position: [f64; 3],
    /// Orientation w, x, y, z.
    pub quat: [f64; 4],
}

impl PoseMessage {
    /// As a buffer of poses takes it.
    pub fn stamped(&self) -> StampedPose {
        StampedPose { time_s: seconds(self.stamp_ns), quat: Quat(self.quat), pos: Vec3(self.position) }
    }
}

/// Joint angles, model order `[rad]`.
#[derive(Clone, Debug, PartialEq)]
pub struct JointMessage {
    /// When they were measured `[ns]`.
    pub stamp_ns: u64,
    /// The angles.
    pub positions: Vec<f64>,
}

/// Anything that reaches perception.
#[derive(Clone, Debug, PartialEq)]
pub enum Message {
    /// An image.
    Picture(Box<PictureMessage>),
    /// A sample of the LiDAR's inertial sensor.
    Imu(ImuMessage),
    /// A scan.
    Scan(ScanMessage),
    /// A pose of another odometry.
    Pose(PoseMessage),
    /// Joint angles.
    Joints(JointMessage),
    /// The robot asks for the estimate now.
    Step {
        /// Time until its motion strikes `[s]`; negative afterwards, infinite before it has chosen one.
        to_strike_s: f64,
    },
}

/// A message with the time of its arrival.
#[derive(Clone, Debug, PartialEq)]
pub struct Arrived {
    /// When it came, by the robot's clock `[ns]`.
    pub at_ns: u64,
    /// The message.
    pub message: Message,
}
