//! What can go wrong.

use paid_runtime::wire::{DAMPING_KEYS, LowState, Remote};

/// A fault of the virtual robot, of its senses, or of the computer that commands it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Fault {
    /// The gantry tilts the robot until it is beyond the limit.
    Tilt,
    /// The gantry turns the robot fast.
    Spin,
    /// A joint's speed is beyond its limit.
    JointSpeed,
    /// The pelvis turns faster than any kick needs, during one.
    SpinInKick,
    /// A joint is faster than any kick needs, during one.
    JointSpeedInKick,
    /// A joint's torque is beyond its limit.
    Torque,
    /// A joint is beyond its range.
    Range,
    /// A winding is hot.
    Winding,
    /// A casing is hot.
    Casing,
    /// A number of the state is NaN.
    NotFinite,
    /// No state comes.
    Silence,
    /// The same state comes again and again.
    Frozen,
    /// Checksums are wrong.
    Checksum,
    /// The robot reports a locked waist.
    ModeMachine,
    /// The remote is switched off.
    RemoteOff,
    /// The stop keys are pressed.
    StopKey,
    /// Ctrl-C.
    StopSignal,
    /// The policy gives NaN.
    ActionNotFinite,
    /// The policy gives a huge action.
    ActionHuge,
    /// The runtime is called seldom: policy steps come late.
    Late,
    /// The runtime hangs, or its thread has panicked.
    Hang,
    /// Runtime and writer are gone, as after `kill -9`.
    Kill,
    /// Somebody else commands the robot too.
    OthersCommand,
    /// Odometry ends before the strike.
    NoOdometry,
    /// The detector detects no ball before the strike.
    NoBall,
}

impl Fault {
    /// All of them.
    pub const ALL: [Self; 25] = [
        Self::Tilt,
        Self::Spin,
        Self::JointSpeed,
        Self::SpinInKick,
        Self::JointSpeedInKick,
        Self::Torque,
        Self::Range,
        Self::Winding,
        Self::Casing,
        Self::NotFinite,
        Self::Silence,
        Self::Frozen,
        Self::Checksum,
        Self::ModeMachine,
        Self::RemoteOff,
        Self::StopKey,
        Self::StopSignal,
        Self::ActionNotFinite,
        Self::ActionHuge,
        Self::Late,
        Self::Hang,
        Self::Kill,
        Self::OthersCommand,
        Self::NoOdometry,
        Self::NoBall,
    ];

    /// As text.
    pub fn name(self) -> &'static str {
        match self {
            Self::Tilt => "tilt beyond 1 rad",
            Self::Spin => "pelvis turns at 8 rad/s",
            Self::JointSpeed => "joint speed",
            Self::SpinInKick => "pelvis at 16 rad/s in a kick",
            Self::JointSpeedInKick => "joint speed in a kick",
            Self::Torque => "joint torque",
            Self::Range => "joint range",
            Self::Winding => "winding at 121 degrees",
            Self::Casing => "casing at 86 degrees",
            Self::NotFinite => "NaN in the state",
            Self::Silence => "no state",
            Self::Frozen => "frozen state",
            Self::Checksum => "wrong checksums",
            Self::ModeMachine => "mode_machine 6",
            Self::RemoteOff => "remote off",
            Self::StopKey => "stop keys L2 and B",
            Self::StopSignal => "Ctrl-C",
            Self::ActionNotFinite => "policy gives NaN",
            Self::ActionHuge => "policy gives a huge action",
            Self::Late => "late policy steps",
            Self::Hang => "runtime hangs or panics",
            Self::Kill => "kill -9",
            Self::OthersCommand => "another commander",
            Self::NoOdometry => "odometry lost before the strike",
            Self::NoBall => "ball lost before the strike",
        }
    }

    /// True for what happens outside the robot and its senses, in or near the computer that commands it: a virtual robot on the
    /// network has nothing to do with it.
    pub fn is_beside_the_robot(self) -> bool {
        match self {
            Self::StopSignal
            | Self::ActionNotFinite
            | Self::ActionHuge
            | Self::Late
            | Self::Hang
            | Self::Kill
            | Self::OthersCommand => true,
            Self::Tilt
            | Self::Spin
            | Self::JointSpeed
            | Self::SpinInKick
            | Self::JointSpeedInKick
            | Self::Torque
            | Self::Range
            | Self::Winding
            | Self::Casing
            | Self::NotFinite
            | Self::Silence
            | Self::Frozen
            | Self::Checksum
            | Self::ModeMachine
            | Self::RemoteOff
            | Self::StopKey
            | Self::NoOdometry
            | Self::NoBall => false,
        }
    }

    /// Changes the robot's messages; the fault began at `since_us` `[us]`.
    pub(crate) fn tamper(self, state: &mut LowState, since_us: u64) {
        let knee = &mut state.motors[3];
        match self {
            Self::JointSpeed => knee.dq = 25.0,
            // Twice the speed limit of the knee.
            Self::JointSpeedInKick => knee.dq = 40.0,
            Self::SpinInKick => state.imu.gyroscope[2] = 16.0,
            Self::Torque => knee.tau_est = 250.0,
            Self::Range => knee.q = -0.5,
            Self::Winding => knee.temperature[1] = 121,
            Self::Casing => knee.temperature[0] = 86,
            Self::NotFinite => knee.dq = f32::NAN,
            Self::Frozen => state.tick = (since_us / 1000) as u32,
            Self::ModeMachine => state.mode_machine = 6,
            Self::RemoteOff => state.wireless_remote = [0; 40],
            Self::StopKey => state.wireless_remote = Remote::pressing(&DAMPING_KEYS),
            _ => {}
        }
    }
}
