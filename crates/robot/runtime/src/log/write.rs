//! Writes a log.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufWriter, ErrorKind, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::records::{MessageHeader, Metadata};
use mcap::{McapError, WriteOptions, Writer};
use serde::Serialize;

use super::{Frame, LogHeader, NAME, STEP, VERSION};
use crate::DeployError;
use crate::message::Packet;
use crate::motors::G1_MOTORS;
use crate::runtime::{Output, Runtime};
use crate::wire::LowState;

/// This many frames are handed to the system at once: a twentieth of a second.
const FLUSH: usize = 25;
/// The body is written with one state in this many.
const BODY_EVERY: usize = 10;

/// Where a log goes: a file, as a rule.
pub trait Sink: Write + Seek + Send {}
impl<S: Write + Seek + Send> Sink for S {}

/// The other topics than `paid/step`, with their JSON schemas.
const POLICY: [&str; 2] = ["paid/policy", POLICY_SCHEMA];
const BODY: [&str; 2] = ["paid/body", BODY_SCHEMA];
const EVENTS: [&str; 2] = ["paid/events", EVENTS_SCHEMA];
const POLICY_SCHEMA: &str = r#"{"type":"object","properties":{
"observation":{"type":"array","items":{"type":"number"}},"action":{"type":"array","items":{"type":"number"}}}}"#;
const BODY_SCHEMA: &str = r#"{"type":"object","properties":{"tick":{"type":"integer"},
"quaternion":{"type":"array","items":{"type":"number"}},"gyroscope":{"type":"array","items":{"type":"number"}},
"joint_pos":{"type":"array","items":{"type":"number"}},"joint_vel":{"type":"array","items":{"type":"number"}},
"torque":{"type":"array","items":{"type":"number"}},"winding":{"type":"array","items":{"type":"integer"}}}}"#;
const EVENTS_SCHEMA: &str = r#"{"type":"object","properties":{"at_us":{"type":"integer"},"from":{"type":"string"},
"to":{"type":"string"},"reason":{"type":"string"}}}"#;

/// Pelvis and joints as the robot reported them: w, x, y, z; `[rad/s]`; `[rad]`; `[rad/s]`; `[N m]`; degrees Celsius.
#[derive(Serialize)]
struct Body {
    tick: u32,
    quaternion: [f32; 4],
    gyroscope: [f32; 3],
    joint_pos: Vec<f32>,
    joint_vel: Vec<f32>,
    torque: Vec<f32>,
    winding: Vec<i16>,
}

impl Body {
    fn of(state: &LowState) -> Self {
        let motors = &state.motors[..G1_MOTORS.len()];
        Self {
            tick: state.tick,
            quaternion: state.imu.quaternion,
            gyroscope: state.imu.gyroscope,
            joint_pos: motors.iter().map(|m| m.q).collect(),
            joint_vel: motors.iter().map(|m| m.dq).collect(),
            torque: motors.iter().map(|m| m.tau_est).collect(),
            winding: motors.iter().map(|m| m.temperature[1]).collect(),
        }
    }
}

/// Writes a log. A disk that is full ends the log, not the robot. A new file that got no step and no end is removed with this.
pub struct LogWriter {
    file: PathBuf,
    /// A file that was made here and has no end yet.
    unfinished: bool,
    out: Option<Writer<BufWriter<Box<dyn Sink>>>>,
    /// Channels of steps, policy, body, events.
    channels: [u16; 4],
    since_flush: usize,
    states: usize,
    written: usize,
    failed: Option<String>,
}

impl LogWriter {
    /// Refuses a log that is there already.
    ///
    /// # Errors
    /// If there is something of this name.
    pub fn check_new(file: &Path) -> Result<(), DeployError> {
        if file.symlink_metadata().is_ok() { Err(occupied(file)) } else { Ok(()) }
    }

    /// Begins a log in a new file.
    ///
    /// # Errors
    /// If the file is there already, or cannot be written.
    pub fn create(file: &Path, header: &LogHeader) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Log { file: file.to_owned(), message };
        let sink = File::create_new(file).map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => occupied(file),
            _ => fail(error.to_string()),
        })?;
        let begun = Self::to(file, Box::new(sink), header);
        if begun.is_err() {
            // A full disk: the empty file would be in the way of the next start.
            let _ = std::fs::remove_file(file);
        }
        begun.map(|mut log| {
            log.unfinished = true;
            log
        })
    }

    /// Begins a log in a sink; `name` stands for it in errors.
    ///
    /// # Errors
    /// If the sink refuses.
    pub fn to(name: &Path, sink: Box<dyn Sink>, header: &LogHeader) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Log { file: name.to_owned(), message };
        let json = serde_json::to_string(header).map_err(|e| fail(e.to_string()))?;
        let begin = || -> Result<_, McapError> {
            let options = WriteOptions::new().compression(None).use_chunks(false).profile("").library("paid");
            let mut out = options.create(BufWriter::with_capacity(1 << 18, sink))?;
            let metadata = [("version", VERSION.to_owned()), ("header", json)];
            let metadata = metadata.map(|(key, value)| (key.to_owned(), value)).into();
            out.write_metadata(&Metadata { name: NAME.to_owned(), metadata })?;
            let mut channels = [out.add_channel(0, STEP, "postcard", &BTreeMap::new())?; 4];
            for (channel, [topic, schema]) in channels[1..].iter_mut().zip([POLICY, BODY, EVENTS]) {
                let id = out.add_schema(topic, "jsonschema", schema.as_bytes())?;
                *channel = out.add_channel(id, topic, "json", &BTreeMap::new())?;
            }
            out.flush()?;
            Ok((out, channels))
        };
        let (out, channels) = begin().map_err(|e| fail(e.to_string()))?;
        Ok(Self {
            file: name.to_owned(),
            unfinished: false,
            out: Some(out),
            channels,
            since_flush: 0,
            states: 0,
            written: 0,
            failed: None,
        })
    }

    /// Why nothing more is written, if so.
    pub fn failed(&self) -> Option<&str> {
        self.failed.as_deref()
    }

    /// Writes the runtime's last step.
    pub fn step(&mut self, now_us: u64, packets: &[Packet], stop: bool, output: &Output, runtime: &Runtime) {
        self.write(&Frame::new(now_us, packets, stop, output, runtime));
    }

    /// Writes a frame. After a failure nothing more is written.
    pub fn write(&mut self, frame: &Frame) {
        if self.out.is_none() {
            return;
        }
        match self.records(frame) {
            Ok(()) => self.written += 1,
            Err(message) => {
                self.failed = Some(message);
                self.out = None;
            }
        }
    }

    fn records(&mut self, frame: &Frame) -> Result<(), String> {
        let Some(out) = &mut self.out else { return Ok(()) };
        let sequence = self.written as u32;
        let [steps, policy, body, events] = self.channels;
        let log_time = 1000 * frame.now_us;
        let mut put = |channel_id: u16, data: &[u8]| {
            let header = MessageHeader { channel_id, sequence, log_time, publish_time: log_time };
            out.write_to_known_channel(&header, data).map_err(|e| e.to_string())
        };
        let json = |value: Result<Vec<u8>, serde_json::Error>| value.map_err(|e| e.to_string());
        put(steps, &postcard::to_stdvec(frame).map_err(|e| e.to_string())?)?;
        if let Some(trace) = &frame.trace {
            put(policy, &json(serde_json::to_vec(trace))?)?;
        }
        for event in &frame.events {
            put(events, &json(serde_json::to_vec(event))?)?;
        }
        for packet in &frame.packets {
            let Packet::LowState(bytes) = packet else { continue };
            if self.states.is_multiple_of(BODY_EVERY)
                && let Ok(state) = LowState::from_cdr(bytes)
            {
                put(body, &json(serde_json::to_vec(&Body::of(&state)))?)?;
            }
            self.states += 1;
        }
        self.since_flush += 1;
        if self.since_flush >= FLUSH {
            self.since_flush = 0;
            out.flush().map_err(|e| e.to_string())?;
        }
        Ok(())
    }

    /// Ends the log; the number of frames.
    ///
    /// # Errors
    /// What went wrong, now or before.
    pub fn finish(mut self) -> Result<usize, DeployError> {
        self.unfinished = false;
        if let Some(mut out) = self.out.take() {
            let ended = out.finish().map_err(|e| e.to_string());
            let ended = ended.and_then(|_| out.into_inner().flush().map_err(|e| e.to_string()));
            self.failed = ended.err();
        }
        match self.failed.take() {
            None => Ok(self.written),
            Some(message) => Err(DeployError::Log { file: std::mem::take(&mut self.file), message }),
        }
    }
}

impl Drop for LogWriter {
    /// Nothing was begun: an empty log would only be in the way of the next start.
    fn drop(&mut self) {
        drop(self.out.take());
        if self.unfinished && self.written == 0 {
            let _ = std::fs::remove_file(&self.file);
        }
    }
}

/// A log that would be written over.
fn occupied(file: &Path) -> DeployError {
    let message = "expected a new file, found one that is there already: name another, or remove it";
    DeployError::Log { file: file.to_owned(), message: message.to_owned() }
}
