//! States of the runtime, and why it leaves them.

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::machine;

/// What the runtime is doing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// Damping, before anything was asked for.
    Passive,
    /// A ramp to the standing pose.
    StandUp,
    /// Standing, waiting for a ball.
    Ready,
    /// The policy follows a motion and kicks.
    Kick,
    /// The motion is over; the policy holds its last pose.
    Settle,
    /// Damping, for good.
    Damping,
}

impl fmt::Display for State {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Passive => "passive",
            Self::StandUp => "stand up",
            Self::Ready => "ready",
            Self::Kick => "kick",
            Self::Settle => "settle",
            Self::Damping => "damping",
        })
    }
}

/// Why the runtime damps.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// Pelvis from upright `[rad]`.
    Tilt(f64),
    /// Angular velocity of the pelvis `[rad/s]`.
    Gyro(f64),
    /// Joint and its speed `[rad/s]`.
    JointSpeed(String, f64),
    /// Joint and its estimated torque `[N m]`.
    Torque(String, f64),
    /// Joint and its angle `[rad]`.
    Range(String, f64),
    /// Joint and degrees Celsius of its winding.
    Winding(String, i16),
    /// Joint and degrees Celsius of its casing.
    Casing(String, i16),
    /// A number of the state is not finite.
    StateNotFinite,
    /// No new state for this long `[s]`.
    StateGap(f64),
    /// This many wrong checksums in a row.
    Checksum(u32),
    /// The `mode_machine` of a robot that the policy cannot move.
    OtherRobot(u8),
    /// `mode_machine` before and after a change on a running robot.
    ModeMachine([u8; 2]),
    /// The remote has been silent for this long `[s]`.
    RemoteLost(f64),
    /// L2 and B.
    StopKey,
    /// Ctrl-C or SIGTERM.
    StopSignal,
    /// Policy steps were late several times in a row, the last one by this much `[s]`.
    Late(f64),
    /// An action that is not finite or beyond the limit.
    Action(f64),
    /// Another program commands the robot.
    OthersCommand,
    /// This controller of the vendor's is in command.
    Vendor(String),
    /// Charge of the battery in percent.
    Battery(f64),
    /// A thread of the program or its link has failed.
    Broken(String),
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Tilt(x) => write!(f, "tilted by {x:.2} rad"),
            Self::Gyro(x) => write!(f, "turning at {x:.1} rad/s"),
            Self::JointSpeed(joint, x) => write!(f, "{joint} at {x:.1} rad/s"),
            Self::Torque(joint, x) => write!(f, "{joint} with {x:.0} N m"),
            Self::Range(joint, x) => write!(f, "{joint} at {x:.2} rad, beyond its range"),
            Self::Winding(joint, x) => write!(f, "winding of {joint} at {x} degrees"),
            Self::Casing(joint, x) => write!(f, "casing of {joint} at {x} degrees"),
            Self::StateNotFinite => f.write_str("a number of the robot's state is not finite"),
            Self::StateGap(x) => write!(f, "no new state for {:.0} ms", 1e3 * x),
            Self::Checksum(n) => write!(f, "{n} wrong checksums in a row"),
            Self::OtherRobot(x) => {
                write!(f, "mode_machine: expected {}, found {x}: {}", machine::EXPECTED, machine::words(*x))
            }
            Self::ModeMachine([before, after]) => {
                write!(f, "mode_machine: it was {before} and is {after} now ({})", machine::words(*after))
            }
            Self::RemoteLost(x) => write!(f, "the remote has been silent for {x:.1} s"),
            Self::StopKey => f.write_str("stop key"),
            Self::StopSignal => f.write_str("stop signal"),
            Self::Late(x) => write!(f, "policy steps late, the last one by {:.0} ms", 1e3 * x),
            Self::Action(x) if x.is_nan() => f.write_str("an action that is not a number"),
            Self::Action(x) => write!(f, "an action of {x}"),
            Self::OthersCommand => f.write_str("another program commands the robot"),
            Self::Vendor(name) => write!(f, "the vendor's controller '{name}' is in command"),
            Self::Battery(x) => write!(f, "battery at {x:.0}%"),
            Self::Broken(message) => f.write_str(message),
        }
    }
}

/// A transition or refusal of the runtime.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Event {
    /// When `[us]`.
    pub at_us: u64,
    /// State before.
    pub from: State,
    /// State after.
    pub to: State,
    /// Why.
    pub reason: String,
}
