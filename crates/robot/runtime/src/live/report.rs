//! What a run reports, and its result.

use serde::Serialize;

use crate::lateness::Lateness;
use crate::runtime::{Event, Latency, State, Status};

/// What is reported while it runs, from a thread of its own that may be slow.
#[derive(Clone, Copy, Debug)]
pub enum Told<'a> {
    /// A transition or a note.
    Event(&'a Event),
    /// The state of things, ten times a second.
    Status(&'a LiveStatus),
}

/// The runtime's status and the machine's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LiveStatus {
    /// The runtime's.
    #[serde(flatten)]
    pub runtime: Status,
    /// States of the robot and commands to it a second, over the last tenth.
    pub rates_hz: [f64; 2],
    /// The longest step of the runtime and the latest command since the last status `[us]`.
    pub longest_step_us: u64,
    /// See `longest_step_us`.
    pub latest_command_us: u64,
    /// True if nothing is sent to the robot.
    pub dry_run: bool,
}

/// How it went.
#[derive(Clone, Debug)]
pub struct LiveReport {
    /// Every transition.
    pub events: Vec<Event>,
    /// The last state.
    pub state: State,
    /// Kicks that have begun.
    pub kicks: usize,
    /// Steps of the runtime.
    pub steps: u64,
    /// The longest step of the runtime, clock time `[us]`.
    pub longest_step_us: u64,
    /// How long steps took in which the policy acted, as a lateness: the packets' intake, tracker, observation, network and command.
    pub policy_steps: Lateness,
    /// How late commands were.
    pub lateness: Lateness,
    /// From the capture of an image of the ball to the first joint targets that it affects.
    pub latency: Latency,
    /// Why the log is not complete, if the disk has failed.
    pub log_failed: Option<String>,
    /// Frames that the log had to drop.
    pub dropped_frames: u64,
    /// True where the system granted real-time priority.
    pub real_time: bool,
    /// What ended it, if it was neither the operator nor the time: a thread's panic, or a writer that was silent for too long.
    pub died: Option<String>,
}

/// Counts a second.
#[derive(Debug, Default)]
pub(super) struct Rates {
    before: Option<(f64, [u64; 2])>,
}

impl Rates {
    /// Rates since the last call `[Hz]`, whose time was earlier than `now_s` `[s]`; zeros at the first one.
    pub fn since_last(&mut self, now_s: f64, counts: [u64; 2]) -> [f64; 2] {
        let before = self.before.replace((now_s, counts));
        before.map_or([0.0; 2], |(then_s, old)| {
            let time = (now_s - then_s).max(1e-6);
            [0, 1].map(|k| counts[k].saturating_sub(old[k]) as f64 / time)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_counts_over_time() {
        let mut rates = Rates::default();
        assert_eq!(rates.since_last(1.0, [100, 7]), [0.0, 0.0]);
        assert_eq!(rates.since_last(1.5, [350, 7]), [500.0, 0.0]);
    }
}
