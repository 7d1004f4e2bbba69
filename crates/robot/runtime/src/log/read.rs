//! Reads a log.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::McapError;
use mcap::records::Record;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use paid_files::{GIT_LFS_POINTER, is_git_lfs_pointer};

use super::{Frame, LogHeader, NAME, STEP, VERSION};
use crate::DeployError;

/// No record is longer `[bytes]`.
const LONGEST: usize = 1 << 26;

/// Reads a log.
pub struct LogReader {
    file: PathBuf,
    input: File,
    records: LinearReader,
    steps: Option<u16>,
    ended: bool,
    /// Whether the record was seen with which a whole log ends.
    whole: bool,
    /// Time of the last step `[us]`.
    last_us: Option<u64>,
    /// What a replay needs.
    pub header: LogHeader,
}

/// What is of interest among the records.
enum Found {
    Header(Box<LogHeader>),
    Frame(Box<Frame>),
}

impl LogReader {
    /// Opens a log.
    ///
    /// # Errors
    /// If it cannot be read, or is no log.
    pub fn open(file: &Path) -> Result<Self, DeployError> {
        let fail = |message: String| DeployError::Log { file: file.to_owned(), message };
        let input = File::open(file).map_err(|e| fail(e.to_string()))?;
        let options =
            LinearReaderOptions::default().with_skip_end_magic(true).with_record_length_limit(LONGEST);
        // Its place is taken by the file's own before anybody sees it.
        let empty = crate::player::PlayerSpec { policy: PathBuf::new(), motions: None, sets: Vec::new() };
        let mut reader = Self {
            file: file.to_owned(),
            input,
            records: LinearReader::new_with_options(options),
            steps: None,
            ended: false,
            whole: false,
            last_us: None,
            header: LogHeader { player: empty, limits: crate::Limits::default() },
        };
        match reader.next_found()? {
            Some(Found::Header(header)) => reader.header = *header,
            _ => return Err(fail(format!("expected a metadata record '{NAME}' first, found none"))),
        }
        Ok(reader)
    }

    /// Whether Git LFS has left the file as a pointer.
    fn is_pointer(&self) -> bool {
        head(&self.file).is_ok_and(|head| is_git_lfs_pointer(&head))
    }

    fn fail(&self, message: String) -> DeployError {
        DeployError::Log { file: self.file.clone(), message }
    }

    /// The next frame; `None` at the end, also where the last record was cut off.
    ///
    /// # Errors
    /// If a record is damaged.
    pub fn next_frame(&mut self) -> Result<Option<Frame>, DeployError> {
        loop {
            match self.next_found()? {
                Some(Found::Frame(frame)) => {
                    self.last_us = Some(frame.now_us);
                    return Ok(Some(*frame));
                }
                Some(Found::Header(_)) => {}
                None => return Ok(None),
            }
        }
    }

    /// After the last frame, if the log was cut off: where its last whole step is.
    pub fn cut_off(&self) -> Option<String> {
        let place = |us: u64| format!("after the step at {:.3} s", us as f64 * 1e-6);
        (self.ended && !self.whole).then(|| {
            let last = self.last_us.map_or_else(|| "before its first step".to_owned(), place);
            format!(
                "{}: the log is cut off {last}: its program was killed, the disk was full, or the file was not copied whole",
                self.file.display()
            )
        })
    }

    fn next_found(&mut self) -> Result<Option<Found>, DeployError> {
        while !self.ended {
            let event = match self.records.next_event() {
                None | Some(Err(McapError::UnexpectedEof)) => {
                    self.ended = true;
                    break;
                }
                Some(Err(McapError::BadMagic)) => {
                    let found = if self.is_pointer() {
                        GIT_LFS_POINTER.join("; ")
                    } else {
                        "something else".to_owned()
                    };
                    return Err(self.fail(format!("expected a log (MCAP), found {found}")));
                }
                Some(Err(McapError::UnsupportedCompression(name))) => {
                    let [expected, found] = paid_files::compressed_chunks(&name);
                    return Err(self.fail(format!("expected {expected}, found {found}")));
                }
                Some(Err(error)) => return Err(self.fail(error.to_string())),
                Some(Ok(event)) => event,
            };
            let found = match event {
                LinearReadEvent::ReadRequest(wanted) => {
                    // Not less than a block, so that a small request is no call to the system.
                    let room = self.records.insert(wanted.max(1 << 16));
                    match self.input.read(room) {
                        Ok(read) => self.records.notify_read(read),
                        Err(error) => return Err(self.fail(error.to_string())),
                    }
                    continue;
                }
                LinearReadEvent::Record { data, opcode } => {
                    mcap::parse_record(opcode, data).map_err(|e| e.to_string()).and_then(|record| {
                        match record {
                            Record::Metadata(metadata) if metadata.name == NAME => {
                                header(&metadata.metadata).map(Some)
                            }
                            Record::Channel(channel) if channel.topic == STEP => {
                                self.steps = Some(channel.id);
                                Ok(None)
                            }
                            Record::Message { header, data } if Some(header.channel_id) == self.steps => {
                                let frame = postcard::from_bytes(&data);
                                let frame = frame.map_err(|e| format!("step {}: {e}", header.sequence));
                                frame.map(|frame| Some(Found::Frame(Box::new(frame))))
                            }
                            // From here on the file repeats itself.
                            Record::DataEnd(_) => {
                                (self.ended, self.whole) = (true, true);
                                Ok(None)
                            }
                            _ => Ok(None),
                        }
                    })
                }
            };
            match found {
                Ok(None) => {}
                Ok(found) => return Ok(found),
                Err(message) => return Err(self.fail(message)),
            }
        }
        Ok(None)
    }
}

/// The first bytes of a file.
fn head(file: &Path) -> std::io::Result<Vec<u8>> {
    let mut head = Vec::new();
    File::open(file)?.take(64).read_to_end(&mut head)?;
    Ok(head)
}

fn header(metadata: &std::collections::BTreeMap<String, String>) -> Result<Found, String> {
    let text = |key: &str| metadata.get(key).map(String::as_str).unwrap_or_default();
    if text("version") != VERSION {
        return Err(format!("version: expected {VERSION}, found '{}'", text("version")));
    }
    serde_json::from_str(text("header"))
        .map(|header| Found::Header(Box::new(header)))
        .map_err(|e| format!("header: {e}"))
}
