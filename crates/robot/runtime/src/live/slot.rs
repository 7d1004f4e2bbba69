//! What the thinking thread leaves for the log: places with room for a step, which go round between the two threads. Filling one allocates nothing
//! but a transition's sentence; the log's thread makes the frame.

use crate::log::Frame;
use crate::message::Packet;
use crate::runtime::{Event, Output, PolicyTrace, Runtime, State};
use crate::wire::LowCmd;

/// Packets that a step has room for; more make it grow.
const PACKETS: usize = 32;

/// Room for a step.
#[derive(Debug)]
pub(super) struct Slot {
    now_us: u64,
    packets: Vec<Packet>,
    stop: bool,
    command: Option<LowCmd>,
    state: State,
    acted: bool,
    trace: PolicyTrace,
    events: Vec<Event>,
}

impl Slot {
    /// Room for a step of this runtime.
    pub fn new(runtime: &Runtime) -> Self {
        let player = runtime.player();
        Self {
            now_us: 0,
            packets: Vec::with_capacity(PACKETS),
            stop: false,
            command: None,
            state: runtime.state(),
            acted: false,
            trace: PolicyTrace {
                observation: Vec::with_capacity(player.policy.obs_dim()),
                action: Vec::with_capacity(player.joints()),
            },
            events: Vec::new(),
        }
    }

    /// Keeps the runtime's last step. The packets move here, and `packets` is empty after it.
    pub fn fill(
        &mut self,
        now_us: u64,
        packets: &mut Vec<Packet>,
        stop: bool,
        output: &Output,
        runtime: &Runtime,
    ) {
        (self.now_us, self.stop, self.state, self.acted) = (now_us, stop, output.state, output.acted);
        self.packets.append(packets);
        self.command.clone_from(&output.command);
        if output.acted {
            self.trace.clone_from(runtime.trace());
        }
        self.events.extend(output.events.iter().cloned());
    }

    /// The frame to write.
    pub fn frame(&mut self) -> Frame {
        Frame {
            now_us: self.now_us,
            packets: std::mem::take(&mut self.packets),
            stop: self.stop,
            command: self.command.as_ref().map(LowCmd::to_cdr).unwrap_or_default(),
            state: self.state,
            trace: self.acted.then(|| self.trace.clone()),
            events: std::mem::take(&mut self.events),
        }
    }

    /// Takes the frame's room back for another step.
    pub fn again(&mut self, frame: Frame) {
        self.packets = frame.packets;
        self.packets.clear();
    }
}
