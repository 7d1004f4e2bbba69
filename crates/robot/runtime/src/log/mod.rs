//! The log of every step, and its replay.
//!
//! A file is MCAP without chunks and compression: every record is on its way to the system at once. It begins with a metadata record
//! `paid-deploy-log` ([`LogHeader`] as JSON). Topics:
//!
//! - `paid/step`: a [`Frame`] in postcard, 500 times a second: all that a replay needs;
//! - `paid/policy`: what the policy got and gave, at each of its steps, as JSON;
//! - `paid/body`: pelvis and joints as the robot reported them, 50 times a second, as JSON; a joint's place is that of
//!   [`crate::G1_MOTORS`];
//! - `paid/events`: transitions and notes, as JSON.
//!
//! Times are the runtime's clock. Frames are handed to the system every twentieth of a second, so that a killed program loses no more; a file
//! that ends within a record is read up to there. A disk that is full ends the log, not the robot.

mod course;
mod read;
mod replay;
mod write;

use serde::{Deserialize, Serialize};

use crate::limits::Limits;
use crate::message::Packet;
use crate::player::PlayerSpec;
use crate::runtime::{Event, Output, PolicyTrace, Runtime, State};
use crate::wire::LowCmd;

pub use course::{Course, CoursePoint};
pub use read::LogReader;
pub use replay::{Replay, ReplayTimes, replay};
pub use write::{LogWriter, Sink};

/// Name of the metadata record, and the version of the format.
const NAME: &str = "paid-deploy-log";
const VERSION: &str = "2";
/// The topic that a replay reads.
const STEP: &str = "paid/step";

/// What a replay needs besides the frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogHeader {
    /// Policy and motions.
    pub player: PlayerSpec,
    /// Limits in force.
    pub limits: Limits,
}

/// A step of the runtime.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// When `[us]`.
    pub now_us: u64,
    /// What had come.
    pub packets: Vec<Packet>,
    /// The operator had asked to end.
    pub stop: bool,
    /// The command in CDR; empty for none.
    pub command: Vec<u8>,
    /// The state after the step.
    pub state: State,
    /// The policy's step.
    pub trace: Option<PolicyTrace>,
    /// What happened.
    pub events: Vec<Event>,
}

impl Frame {
    /// Of the inputs and the output of the runtime's last step.
    pub fn new(now_us: u64, packets: &[Packet], stop: bool, output: &Output, runtime: &Runtime) -> Self {
        Self {
            now_us,
            packets: packets.to_vec(),
            stop,
            command: output.command.as_ref().map(LowCmd::to_cdr).unwrap_or_default(),
            state: output.state,
            trace: output.acted.then(|| runtime.trace().clone()),
            events: output.events.clone(),
        }
    }
}
