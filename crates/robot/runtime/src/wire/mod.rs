//! The robot's messages, byte for byte.
//!
//! A message has two layouts. On the network it is CDR: every number is aligned to its own size, structs are not. The checksum is
//! computed over the vendor's C struct, in which nested structs are aligned and padded with zeros. One walk over the fields serves both.

mod bms_state;
mod crc;
mod low_cmd;
mod low_state;
mod remote;
mod walk;

pub use bms_state::BmsState;
pub use crc::crc32;
pub use low_cmd::{LowCmd, MotorCmd};
pub use low_state::{ImuState, LowState, MotorState};
pub use remote::{DAMPING_KEYS, Key, Remote};
pub use walk::WireError;
pub(crate) use walk::{Layout, Message};

/// Motors of a message; a G1 with 29 joints uses the first 29.
pub const MOTORS: usize = 35;
/// `mode_machine` of a G1 with 29 free joints.
pub const MODE_MACHINE_G1_29: u8 = 5;
/// Time between two commands `[us]`.
pub const COMMAND_US: u64 = 2_000;
/// The largest DDS domain: the ports of a larger one, 7400 + 250 x domain and more, do not fit into 16 bits and wrap around to another's.
pub const LARGEST_DOMAIN: u16 = 232;

/// What the robot is that reports this `mode_machine` (the vendor's description of the G1, read 2026-11-28).
pub(crate) fn machine(mode: u8) -> &'static str {
    match mode {
        MODE_MACHINE_G1_29 => "29 free joints",
        1 | 4 | 10 => "a G1 with 23 joints, which lacks joints that the policy moves",
        3 | 6 | 12 | 14 | 16 => {
            "a G1 whose waist is locked, so that it cannot turn and lean as the policy asks; unlock it as the vendor describes"
        }
        2 => "a prototype of the G1 with 29 joints, whose motors are not known here",
        11 | 15 => "a G1 with 29 free joints whose hips have another gear; no policy is trained for it yet",
        13 => "a G1 with 29 free joints whose wrists have another motor; no policy is trained for it yet",
        18 => "a G1 with 29 free joints and a head of two joints; no policy is trained for it yet",
        _ => "another robot",
    }
}
