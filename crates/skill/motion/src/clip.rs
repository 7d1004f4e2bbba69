//! One motion.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

/// The leg that kicks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum KickLeg {
    /// Left.
    Left,
    /// Right.
    Right,
}

impl KickLeg {
    /// Position in pairs that are ordered left, right (such as `RobotSpec::feet`).
    pub fn index(self) -> usize {
        match self {
            KickLeg::Left => 0,
            KickLeg::Right => 1,
        }
    }
}

impl fmt::Display for KickLeg {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            KickLeg::Left => "left",
            KickLeg::Right => "right",
        })
    }
}

impl FromStr for KickLeg {
    type Err = String;

    /// Accepts `left` and `right`.
    fn from_str(label: &str) -> Result<Self, String> {
        match label {
            "left" => Ok(KickLeg::Left),
            "right" => Ok(KickLeg::Right),
            other => Err(format!("'{other}'")),
        }
    }
}

/// A motion at a fixed frame rate, joints and bodies in model order. Row `t` of a `[T, N]` array is at `t * N ..`.
#[derive(Clone, Debug, PartialEq)]
pub struct Clip {
    /// File name without extension.
    pub name: String,
    /// Where it was read from.
    pub path: PathBuf,
    /// Frames a second.
    pub fps: f64,
    /// The label of the kicking leg.
    pub kick_leg: KickLeg,
    /// The frame in which the foot meets the ball, if it is known.
    pub kick_frame: Option<usize>,
    /// Terms of use, if the file states them.
    pub license: Option<String>,
    /// T.
    pub frames: usize,
    /// J.
    pub joints: usize,
    /// B.
    pub bodies: usize,
    /// Joint angles `[T, J]` `[rad]`.
    pub joint_pos: Vec<f64>,
    /// Joint velocities `[T, J]` `[rad/s]`.
    pub joint_vel: Vec<f64>,
    /// Origins of the body frames `[T, B]`, world `[m]`.
    pub body_pos: Vec<[f64; 3]>,
    /// Orientations of the body frames `[T, B]`, unit, w, x, y, z.
    pub body_quat: Vec<[f64; 4]>,
    /// Velocities of the bodies' centers of mass `[T, B]`, world axes `[m/s]`.
    pub body_lin_vel: Vec<[f64; 3]>,
    /// Angular velocities `[T, B]`, world axes `[rad/s]`.
    pub body_ang_vel: Vec<[f64; 3]>,
}

impl Clip {
    /// Time from the first to the last frame `[s]`.
    pub fn duration_s(&self) -> f64 {
        (self.frames - 1) as f64 / self.fps
    }
    /// Joint angles of frame `t` `[rad]`.
    pub fn joint_pos(&self, t: usize) -> &[f64] {
        &self.joint_pos[t * self.joints..(t + 1) * self.joints]
    }
    /// Joint velocities of frame `t` `[rad/s]`.
    pub fn joint_vel(&self, t: usize) -> &[f64] {
        &self.joint_vel[t * self.joints..(t + 1) * self.joints]
    }
    /// Body origins of frame `t`, world `[m]`.
    pub fn body_pos(&self, t: usize) -> &[[f64; 3]] {
        &self.body_pos[t * self.bodies..(t + 1) * self.bodies]
    }
    /// Body orientations of frame `t`, w, x, y, z.
    pub fn body_quat(&self, t: usize) -> &[[f64; 4]] {
        &self.body_quat[t * self.bodies..(t + 1) * self.bodies]
    }
    /// Velocities of the bodies' centers of mass of frame `t`, world axes `[m/s]`.
    pub fn body_lin_vel(&self, t: usize) -> &[[f64; 3]] {
        &self.body_lin_vel[t * self.bodies..(t + 1) * self.bodies]
    }
    /// Angular velocities of frame `t`, world axes `[rad/s]`.
    pub fn body_ang_vel(&self, t: usize) -> &[[f64; 3]] {
        &self.body_ang_vel[t * self.bodies..(t + 1) * self.bodies]
    }
}
