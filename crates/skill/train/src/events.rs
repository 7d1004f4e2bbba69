//! TensorBoard event files: TFRecord frames around `tensorflow.Event` messages (fields from `event.proto`).

use std::fs::File;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::time::{SystemTime, UNIX_EPOCH};

use prost::Message;

use crate::TrainError;

/// `tensorflow.Event`, the fields that scalars need.
#[derive(Clone, PartialEq, Message)]
pub struct Event {
    /// Seconds since 1970.
    #[prost(double, tag = "1")]
    pub wall_time: f64,
    /// Training iteration.
    #[prost(int64, tag = "2")]
    pub step: i64,
    /// What the event says.
    #[prost(oneof = "What", tags = "3, 5, 7")]
    pub what: Option<What>,
}

/// The `what` field of [`Event`].
#[derive(Clone, PartialEq, prost::Oneof)]
pub enum What {
    /// The first event of a file.
    #[prost(string, tag = "3")]
    FileVersion(String),
    /// Scalars.
    #[prost(message, tag = "5")]
    Summary(Summary),
    /// Start of a session: TensorBoard drops earlier events from this step on.
    #[prost(message, tag = "7")]
    SessionLog(SessionLog),
}

/// `tensorflow.Summary`.
#[derive(Clone, PartialEq, Message)]
pub struct Summary {
    /// One entry a tag.
    #[prost(message, repeated, tag = "1")]
    pub value: Vec<Value>,
}

/// `tensorflow.Summary.Value` with a scalar.
#[derive(Clone, PartialEq, Message)]
pub struct Value {
    /// Name of the curve.
    #[prost(string, tag = "1")]
    pub tag: String,
    /// The number.
    #[prost(float, optional, tag = "2")]
    pub simple_value: Option<f32>,
}

/// `tensorflow.SessionLog`.
#[derive(Clone, PartialEq, Message)]
pub struct SessionLog {
    /// 1 is START.
    #[prost(int32, tag = "1")]
    pub status: i32,
}

/// An open event file.
#[derive(Debug)]
pub struct EventWriter {
    path: PathBuf,
    file: File,
}

/// How the names of event files begin.
pub(crate) const EVENTS: &str = "events.out.tfevents";

impl EventWriter {
    /// Opens a new event file in `folder`. Events of earlier files of the folder from iteration `first_step` on are
    /// declared void, as after a resume from an older checkpoint.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn create(folder: &Path, first_step: u64) -> Result<Self, TrainError> {
        let seconds = wall_time() as u64;
        // Two starts within a second get different names.
        let mut number = 0;
        let (path, file) = loop {
            let path = folder.join(format!("{EVENTS}.{seconds:010}.paid.{number}"));
            match File::options().write(true).create_new(true).open(&path) {
                Ok(file) => break (path, file),
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => number += 1,
                Err(source) => return Err(TrainError::Write { path, source }),
            }
        };
        let mut writer = Self { path, file };
        writer.append(0, What::FileVersion("brain.Event:2".to_owned()))?;
        if first_step > 0 {
            writer.append(first_step, What::SessionLog(SessionLog { status: 1 }))?;
        }
        Ok(writer)
    }

    /// Appends scalars of one iteration and hands them to the operating system.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn scalars(&mut self, step: u64, values: &[(String, f64)]) -> Result<(), TrainError> {
        let value = values
            .iter()
            .map(|(tag, value)| Value { tag: tag.clone(), simple_value: Some(*value as f32) })
            .collect();
        self.append(step, What::Summary(Summary { value }))
    }

    fn append(&mut self, step: u64, what: What) -> Result<(), TrainError> {
        let event = Event { wall_time: wall_time(), step: step as i64, what: Some(what) };
        self.file.write_all(&frame(&event.encode_to_vec())).map_err(TrainError::write(&self.path))
    }
}

fn wall_time() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |d| d.as_secs_f64())
}

/// TFRecord's checksum: CRC-32C, rotated and offset.
fn masked_crc(bytes: &[u8]) -> u32 {
    crc32c::crc32c(bytes).rotate_right(15).wrapping_add(0xa282_ead8)
}

/// A TFRecord: length, its checksum, the data, its checksum; little endian.
pub fn frame(data: &[u8]) -> Vec<u8> {
    let length = (data.len() as u64).to_le_bytes();
    let mut record = Vec::with_capacity(data.len() + 16);
    record.extend_from_slice(&length);
    record.extend_from_slice(&masked_crc(&length).to_le_bytes());
    record.extend_from_slice(data);
    record.extend_from_slice(&masked_crc(data).to_le_bytes());
    record
}

#[cfg(test)]
/// The data of all whole records; `None` if a checksum or length does not fit.
fn unframe(mut bytes: &[u8]) -> Option<Vec<&[u8]>> {
    let mut records = Vec::new();
    while !bytes.is_empty() {
        let (length, rest) = bytes.split_at_checked(8)?;
        let (length_crc, rest) = rest.split_at_checked(4)?;
        let size = usize::try_from(u64::from_le_bytes(length.try_into().ok()?)).ok()?;
        let (data, rest) = rest.split_at_checked(size)?;
        let (data_crc, rest) = rest.split_at_checked(4)?;
        if masked_crc(length).to_le_bytes() != length_crc || masked_crc(data).to_le_bytes() != data_crc {
            return None;
        }
        records.push(data);
        bytes = rest;
    }
    Some(records)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_matches_known_bytes() {
        assert_eq!(crc32c::crc32c(b"123456789"), 0xe306_9283, "the published check value of CRC-32C");
        // TensorFlow's event files start with these twelve bytes: a record of 24 bytes and the masked checksum of that.
        assert_eq!(frame(&[0; 24])[..12], [0x18, 0, 0, 0, 0, 0, 0, 0, 0xa3, 0x7f, 0x4b, 0x22]);
        let record = frame(b"123456789");
        assert_eq!(record.len(), 25);
        assert_eq!(record[..8], [9, 0, 0, 0, 0, 0, 0, 0]);
        assert_eq!(record[12..21], *b"123456789");
    }

    #[test]
    fn scalars_survive_a_round_trip() {
        let folder = tempfile::tempdir().expect("folder");
        let mut writer = EventWriter::create(folder.path(), 7).expect("create");
        writer.scalars(8, &[("Loss/surrogate".to_owned(), -0.5), ("a".to_owned(), 2.0)]).expect("write");
        let bytes = std::fs::read(&writer.path).expect("read");
        let events: Vec<Event> = unframe(&bytes)
            .expect("whole records")
            .into_iter()
            .map(|data| Event::decode(data).expect("event"))
            .collect();
        assert_eq!(events.len(), 3);
        assert_eq!(events[0].what, Some(What::FileVersion("brain.Event:2".to_owned())));
        assert_eq!((events[1].step, &events[1].what), (7, &Some(What::SessionLog(SessionLog { status: 1 }))));
        let Some(What::Summary(summary)) = &events[2].what else { panic!("scalars expected") };
        assert_eq!(events[2].step, 8);
        assert_eq!(summary.value[0].tag, "Loss/surrogate");
        assert_eq!(summary.value[0].simple_value, Some(-0.5));
        assert!(unframe(&bytes[..bytes.len() - 1]).is_none(), "a cut file is recognized");
    }
}
