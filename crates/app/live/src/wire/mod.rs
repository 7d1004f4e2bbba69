//! What page and program say to each other, byte by byte. Numbers are little endian; lengths in meters, angles in radians, the
//! pitch's axes (see [`crate::Pose2`]).
//!
//! The program sends texts (JSON: first the scene, then the board whenever it changes) and [`Frame`]s; the page sends [`Command`]s.
//! Every binary message starts with [`VERSION`].

mod command;
mod frame;

pub use command::{Command, CommandError};
pub use frame::{Belief, Body, Flags, Force, Frame};

/// Version of the messages. A page of another version is informed and reloads itself.
pub const VERSION: u8 = 2;
/// Longest message that a page may send `[bytes]`.
pub const LONGEST_COMMAND: usize = 32;
