//! The log of every step, and its replay.
//!
//! A file begins with the line `paid-deploy-log 1` and a line of JSON ([`LogHeader`]). Then come frames: a length (four bytes, little-endian)
//! and a [`Frame`] in postcard. Frames are handed to the system ten times a second, so that a killed program loses no more; a file that
//! ends within a frame is read up to there.

use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use crate::DeployError;
use crate::limits::Limits;
use crate::message::Packet;
use crate::player::{Player, PlayerSpec};
use crate::runtime::{Event, Output, PolicyTrace, Runtime, State};
use crate::wire::LowCmd;

const MAGIC: &str = "paid-deploy-log 1";
/// Frames are handed to the system after so many.
const FLUSH: usize = 50;
/// No frame is longer `[bytes]`.
const LONGEST: usize = 1 << 20;

/// What a replay needs beside the frames.
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

/// Writes a log. A disk that is full ends the log, not the robot.
pub struct LogWriter {
    file: PathBuf,
    out: Option<BufWriter<File>>,
    since_flush: usize,
    written: usize,
    failed: Option<String>,
}

impl LogWriter {
    /// Begins a log.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(file: &Path, header: &LogHeader) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Log { file: file.to_owned(), message };
        let mut out = BufWriter::with_capacity(1 << 18, File::create(file).map_err(|e| fail(e.to_string()))?);
        let json = serde_json::to_string(header).map_err(|e| fail(e.to_string()))?;
        writeln!(out, "{MAGIC}\n{json}").and_then(|()| out.flush()).map_err(|e| fail(e.to_string()))?;
        Ok(Self { file: file.to_owned(), out: Some(out), since_flush: 0, written: 0, failed: None })
    }

    /// Writes the runtime's last step.
    pub fn step(&mut self, now_us: u64, packets: &[Packet], stop: bool, output: &Output, runtime: &Runtime) {
        self.write(&Frame::new(now_us, packets, stop, output, runtime));
    }

    /// Writes a frame. After a failure nothing more is written.
    pub fn write(&mut self, frame: &Frame) {
        let Some(out) = &mut self.out else { return };
        self.since_flush += 1;
        let flush = self.since_flush >= FLUSH;
        let bytes = postcard::to_stdvec(frame).map_err(|e| e.to_string());
        let done = bytes.and_then(|bytes| {
            out.write_all(&(bytes.len() as u32).to_le_bytes())
                .and_then(|()| out.write_all(&bytes))
                .and_then(|()| if flush { out.flush() } else { Ok(()) })
                .map_err(|e| e.to_string())
        });
        match done {
            Ok(()) => self.written += 1,
            Err(message) => {
                self.failed = Some(message);
                self.out = None;
            }
        }
        if flush {
            self.since_flush = 0;
        }
    }

    /// Ends the log; the number of frames.
    ///
    /// # Errors
    /// What went wrong, now or before.
    pub fn finish(mut self) -> Result<usize, DeployError> {
        if let Some(out) = &mut self.out
            && let Err(error) = out.flush()
        {
            self.failed = Some(error.to_string());
        }
        match self.failed {
            None => Ok(self.written),
            Some(message) => Err(DeployError::Log { file: self.file, message }),
        }
    }
}

/// Reads a log.
pub struct LogReader {
    file: PathBuf,
    input: BufReader<File>,
    /// What a replay needs.
    pub header: LogHeader,
}

impl LogReader {
    /// Opens a log.
    ///
    /// # Errors
    /// If it cannot be read, or is no log.
    pub fn open(file: &Path) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Log { file: file.to_owned(), message };
        let mut input = BufReader::new(File::open(file).map_err(|e| fail(e.to_string()))?);
        let mut lines = [String::new(), String::new()];
        for line in &mut lines {
            (&mut input).take(LONGEST as u64).read_line(line).map_err(|e| fail(e.to_string()))?;
        }
        if lines[0].trim_end() != MAGIC {
            return Err(fail(format!("line 1: expected '{MAGIC}', found something else")));
        }
        let header = serde_json::from_str(&lines[1]).map_err(|e| fail(format!("line 2: {e}")))?;
        Ok(Self { file: file.to_owned(), input, header })
    }

    /// The next frame; `None` at the end, also where the last frame was cut off.
    ///
    /// # Errors
    /// If a frame is damaged.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, DeployError> {
        let mut length = [0; 4];
        if self.input.read_exact(&mut length).is_err() {
            return Ok(None);
        }
        let length = u32::from_le_bytes(length) as usize;
        let fail = |message: String| DeployError::Log { file: self.file.clone(), message };
        if length > LONGEST {
            return Err(fail(format!("a frame: expected up to {LONGEST} bytes, found {length}")));
        }
        let mut bytes = vec![0; length];
        if self.input.read_exact(&mut bytes).is_err() {
            return Ok(None);
        }
        postcard::from_bytes(&bytes).map(Some).map_err(|e| fail(format!("a frame: {e}")))
    }
}

/// What a replay found.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replay {
    /// Frames.
    pub frames: usize,
    /// Of these with a policy step.
    pub policy_steps: usize,
    /// The first frame that came out otherwise, and in what.
    pub difference: Option<(usize, &'static str)>,
}

/// Runs a log's packets through a new runtime and compares everything bit for bit.
///
/// # Errors
/// If the log is damaged.
pub fn replay(log: &mut LogReader, player: &Arc<Player>) -> Result<Replay, DeployError> {
    let mut runtime = Runtime::new(Arc::clone(player), log.header.limits.clone());
    let mut out = Replay { frames: 0, policy_steps: 0, difference: None };
    while let Some(frame) = log.next_frame()? {
        let output = runtime.step(frame.now_us, &frame.packets, frame.stop);
        let again = Frame::new(frame.now_us, &frame.packets, frame.stop, &output, &runtime);
        let bits = |trace: &Option<PolicyTrace>| {
            trace
                .as_ref()
                .map(|t| t.observation.iter().chain(&t.action).map(|x| x.to_bits()).collect::<Vec<_>>())
        };
        let what = if bits(&again.trace) != bits(&frame.trace) {
            Some("the policy's step")
        } else if again.command != frame.command {
            Some("the command")
        } else if again.state != frame.state || again.events != frame.events {
            Some("the state")
        } else {
            None
        };
        if let (Some(what), None) = (what, out.difference) {
            out.difference = Some((out.frames, what));
        }
        out.frames += 1;
        out.policy_steps += usize::from(frame.trace.is_some());
    }
    Ok(out)
}
