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
#[cfg(feature = "dds")]
pub(crate) use walk::{Layout, Message};

/// Motors of a message; a G1 with 29 joints uses the first 29.
pub const MOTORS: usize = 35;
/// Time between two commands `[us]`.
pub const COMMAND_US: u64 = 2_000;
/// The largest DDS domain: the ports of a larger one, 7400 + 250 x domain and more, do not fit into 16 bits and wrap around to another's.
const LARGEST_DOMAIN: u16 = 232;

/// A DDS domain whose ports exist. `None` is what is no number at all.
///
/// # Errors
/// What was expected.
pub fn check_domain(found: Option<u16>) -> Result<u16, String> {
    let good = found.filter(|domain| *domain <= LARGEST_DOMAIN);
    good.ok_or_else(|| format!("expected a whole number from 0 to {LARGEST_DOMAIN}"))
}
