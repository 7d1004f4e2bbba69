//! What travels between robot, perception and runtime.

use paid_lanes::Mat3;
use serde::{Deserialize, Serialize};

/// An image that the ball detector has looked at.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BallDetection {
    /// When it was taken, on the clock of the senses, which the runtime maps to its own by what came fastest `[us]`.
    pub captured_us: u64,
    /// Center of the ball in the frame of the body that carries the camera (torso) `[m]`; `None`: no ball in it.
    pub ball: Option<[f64; 3]>,
    /// Expected standard deviation on each axis `[m]`.
    pub deviation_m: f64,
}

/// A pose from odometry. Its frame is fixed to the ground, z up, with origin and heading of its own.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct OdometryPose {
    /// When the robot was there, on the clock of the senses `[us]`.
    pub stamp_us: u64,
    /// Origin of the pelvis `[m]`.
    pub position: [f64; 3],
    /// Pelvis in odometry's frame: w, x, y, z.
    pub quaternion: [f64; 4],
}

/// The torso by the robot's own odometry. Ages, not times: who makes it and who takes it need no common clock.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TorsoPose {
    /// How long ago the torso was there when this is handed over `[us]`.
    pub age_us: u64,
    /// Numbers odometry's frames: places of another one mean nothing.
    pub frame: u32,
    /// Origin of the torso in odometry's frame, z up `[m]`.
    pub position: [f64; 3],
    /// Torso in odometry's frame: w, x, y, z.
    pub quaternion: [f64; 4],
}

/// A ball that perception knows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BallReport {
    /// Center (x, y), odometry's frame `[m]`.
    pub position: [f64; 2],
    /// Its velocity `[m/s]`.
    pub velocity: [f64; 2],
    /// Variance of the position `[m^2]`, covariance of position and velocity `[m^2/s]`, variance of the velocity `[m^2/s^2]`, each axis.
    pub covariance: [f64; 3],
    /// Probability that it lies still.
    pub rest: f64,
    /// Time since the capture of the last image that was used `[s]`.
    pub age_s: f64,
    /// Images that have shown this ball, from its first on.
    pub looks: u32,
    /// Numbers the balls.
    pub id: u32,
    /// True if it is not where it should be, was not seen for long, or could be anywhere.
    pub lost: bool,
}

/// Perception's estimate, some fifty times a second.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct EyesReport {
    /// How long ago this held when it is handed over `[us]`.
    pub age_us: u64,
    /// Time from the arrival of the last trusted image to when this held `[us]`; `None`: there was none.
    pub picture_age_us: Option<u64>,
    /// The frame of odometry that the ball is in, as in [`TorsoPose`].
    pub frame: u32,
    /// Height of the floor in that frame `[m]`: where the soles were when the robot became ready, or when kicks were allowed.
    pub floor_m: Option<f64>,
    /// The ball to kick.
    pub ball: Option<BallReport>,
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
    /// An image.
    Detection(BallDetection),
    /// A pose.
    Odometry(OdometryPose),
    /// Center of the goal (x, y), odometry's frame `[m]`.
    Goal([f64; 2]),
    /// Charge of the battery in percent.
    Battery(f64),
    /// The torso by the robot's own odometry.
    Torso(TorsoPose),
    /// The estimates of onboard perception.
    Eyes(EyesReport),
    /// Center of the goal ahead of the torso and to its left, as the operator gives it `[m]`.
    GoalAhead([f64; 2]),
    /// The vendor's controller that is in command, as the motion switcher reports it; empty: it is released.
    Master(String),
    /// Keys of the remote that the operator has pressed on the keyboard, a bit each as in [`crate::wire::Remote`].
    Keys(u16),
    /// A part of the runtime's own program has failed, and why. Never from the network.
    Broken(String),
}

/// Unit quaternion (w, x, y, z) of a rotation, w not negative: as the robot sends it.
pub fn quaternion(rot: &Mat3<f64>) -> [f64; 4] {
    let q = rot.to_quat().0;
    if q[0] < 0.0 { q.map(|x| -x) } else { q }
}

#[cfg(test)]
mod tests {
    use paid_lanes::Quat;

    use super::*;

    #[test]
    fn a_quaternion_comes_back_from_its_rotation() {
        let wanted =
            [[0.9, 0.1, -0.3, 0.2], [0.01, 1.0, 0.1, 0.0], [0.1, 0.0, -1.0, 0.3], [0.0, 0.2, 0.1, 0.9]];
        for q in wanted {
            let q = Quat::<f64>(q).normalize();
            let back = quaternion(&q.to_mat());
            let dot: f64 = q.0.iter().zip(back).map(|(a, b)| a * b).sum();
            assert!((dot.abs() - 1.0).abs() < 1e-12, "{q:?} {back:?}");
        }
    }
}
