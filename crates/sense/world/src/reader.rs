//! Reads a recording again.

use std::path::{Path, PathBuf};

use mcap::MessageStream;
use mcap::read::Options;
use paid_files::{GIT_LFS_POINTER, is_git_lfs_pointer};
use paid_vision::detect::Detector;
use paid_vision::{ColorImage, DepthImage, Intrinsics, PixelBox};

use crate::cdr::{CdrReader, Wrong};
use crate::recorder::believed_bytes;
use crate::schema;
use crate::setup::SetupRecord;
use crate::{
    Arrived, Believed, ImuMessage, JointMessage, Message, PictureMessage, PoseMessage, ScanMessage, Sight,
    SightError, SightSetup,
};

/// What a recording holds, in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Recorded {
    /// What reached perception.
    Message(Arrived),
    /// The recorded estimate.
    Believed {
        /// At this time `[ns]`.
        at_ns: u64,
        /// As bytes.
        bytes: Vec<u8>,
    },
}

impl Recorded {
    /// Whether a belief is the recorded one, to the last bit of every number.
    pub fn is(&self, believed: &Believed) -> bool {
        matches!(self, Self::Believed { bytes, .. } if *bytes == believed_bytes(believed))
    }
}

/// A recording in memory.
#[derive(Debug)]
pub struct Recording {
    path: PathBuf,
    bytes: Vec<u8>,
}

/// Sees topic, time of arrival, time of making `[ns]` and data of a message; false: it has seen enough.
type See<'a> = dyn FnMut(&str, u64, u64, &[u8]) -> Result<bool, Wrong> + 'a;

/// Parts of an image that wait for its color.
#[derive(Default)]
struct Parts {
    intrinsics: Option<Intrinsics>,
    depth: Option<DepthImage>,
    boxes: Option<Vec<PixelBox>>,
}

impl Recording {
    /// Reads a file.
    ///
    /// # Errors
    /// If it cannot be read.
    pub fn open(path: &Path) -> Result<Self, SightError> {
        let bytes =
            std::fs::read(path).map_err(|source| SightError::File { path: path.to_owned(), source })?;
        Ok(Self { path: path.to_owned(), bytes })
    }

    /// From bytes; `path` is named in errors.
    pub fn from_bytes(path: &Path, bytes: Vec<u8>) -> Self {
        Self { path: path.to_owned(), bytes }
    }

    /// The setup of the recorded perception; `detector` is the network of the user, where they had one.
    ///
    /// # Errors
    /// If the recording has no setup, or one that cannot be had here.
    pub fn setup(&self, detector: Option<Detector>) -> Result<SightSetup, SightError> {
        let mut text = None;
        self.each(&mut |topic, _, _, data| {
            if topic == schema::SETUP.name {
                text = Some(CdrReader::new(data)?.string()?);
            }
            Ok(text.is_none())
        })?;
        let wrong = |expected: &str, found: String| self.wrong(schema::SETUP.name, expected, found);
        let Some(text) = text else {
            return Err(wrong("a setup of the eyes", "none".to_owned()));
        };
        let record: SetupRecord =
            serde_json::from_str(&text).map_err(|error| wrong("a setup of the eyes", error.to_string()))?;
        record.setup(detector).map_err(|error| self.placed(schema::SETUP.name.to_owned(), error))
    }

    /// The eyes that were recorded, before they saw anything; `detector` as for [`Self::setup`].
    ///
    /// # Errors
    /// As [`Self::setup`], or if a part of the setup makes no sense.
    pub fn sight(&self, detector: Option<Detector>) -> Result<Sight, SightError> {
        let sight = Sight::new(self.setup(detector)?);
        sight.map_err(|error| self.placed(schema::SETUP.name.to_owned(), error))
    }

    /// Everything that it holds, in its order; topics of others are passed over. Of a file that was cut off ([`Self::cut_at`]), what comes
    /// before.
    ///
    /// # Errors
    /// If it is no MCAP file, or a message is not what its topic says, or `take` fails. What came before has been given then.
    pub fn read(&self, mut take: impl FnMut(Recorded) -> Result<(), SightError>) -> Result<(), SightError> {
        let mut parts = Parts::default();
        let (mut failed, mut number) = (None, 0_usize);
        self.each(&mut |topic, at_ns, made_ns, data| {
            if let Some(recorded) = decode(topic, at_ns, made_ns, data, &mut parts)?
                && let Err(error) = take(recorded)
            {
                failed = Some(self.placed(format!("{topic}, message {number}"), error));
            }
            number += 1;
            Ok(failed.is_none())
        })?;
        failed.map_or(Ok(()), Err)
    }

    /// If the file is cut off: where its last whole record ends. [`Self::read`] reads up to there.
    pub fn cut_at(&self) -> Option<usize> {
        crate::chunks::fit(&self.bytes).ok().flatten().map(|cut| cut.end())
    }

    /// Calls `see` with topic, time of arrival, time of making `[ns]` and data of every message, until it returns false.
    fn each(&self, see: &mut See<'_>) -> Result<(), SightError> {
        let whole = |error: mcap::McapError| self.wrong("the file", "a whole MCAP file", error.to_string());
        if is_git_lfs_pointer(&self.bytes) {
            return Err(self.wrong("the file", "an MCAP file", GIT_LFS_POINTER.join("; ")));
        }
        let cut = crate::chunks::fit(&self.bytes)
            .map_err(|(expected, found)| self.wrong("the file", &expected, found))?;
        let repaired = cut.map(|cut| cut.repaired(&self.bytes));
        let stream = match &repaired {
            Some(bytes) => MessageStream::new_with_options(bytes, Options::IgnoreEndMagic.into()),
            None => MessageStream::new(&self.bytes),
        };
        for (number, message) in stream.map_err(whole)?.enumerate() {
            let message = message.map_err(whole)?;
            let topic = message.channel.topic.as_str();
            match see(topic, message.log_time, message.publish_time, &message.data) {
                Ok(true) => {}
                Ok(false) => return Ok(()),
                Err((expected, found)) => {
                    return Err(self.wrong(&format!("{topic}, message {number}"), &expected, found));
                }
            }
        }
        Ok(())
    }

    /// An error with the place where it comes from.
    fn placed(&self, place: String, error: SightError) -> SightError {
        SightError::Place { path: self.path.clone(), place, source: Box::new(error) }
    }

    /// Something that is not what it should be.
    pub(crate) fn wrong(&self, place: &str, expected: &str, found: String) -> SightError {
        SightError::Recording {
            path: self.path.clone(),
            place: place.to_owned(),
            expected: expected.to_owned(),
            found,
        }
    }
}

/// A message of a topic; `None` for a part of an image and for topics that are not used.
fn decode(
    topic: &str,
    at_ns: u64,
    made_ns: u64,
    data: &[u8],
    parts: &mut Parts,
) -> Result<Option<Recorded>, Wrong> {
    let mut cdr = match schema::ALL.iter().find(|known| known.name == topic) {
        Some(_) => CdrReader::new(data)?,
        None => return Ok(None),
    };
    let message = if topic == schema::CAMERA.name {
        parts.intrinsics = Some(camera(&mut cdr)?);
        return Ok(None);
    } else if topic == schema::DEPTH.name {
        parts.depth = Some(depth(&mut cdr)?);
        return Ok(None);
    } else if topic == schema::BOXES.name {
        cdr.header()?;
        let sides = cdr.f64_list()?;
        let boxes = sides.chunks_exact(4).map(|s| PixelBox { min: [s[0], s[1]], max: [s[2], s[3]] });
        parts.boxes = Some(boxes.collect());
        return Ok(None);
    } else if topic == schema::COLOR.name {
        let (captured_ns, color) = color(&mut cdr)?;
        let Parts { intrinsics, depth, boxes } = std::mem::take(parts);
        let Some(intrinsics) = intrinsics else {
            return Err(("a CameraInfo before its image".to_owned(), "none".to_owned()));
        };
        Message::Picture(Box::new(PictureMessage { captured_ns, color, depth, intrinsics, boxes }))
    } else if topic == schema::IMU.name {
        let (stamp_ns, _) = cdr.header()?;
        cdr.f64s::<13>()?;
        let gyro = cdr.f64s()?;
        cdr.f64s::<9>()?;
        Message::Imu(ImuMessage { stamp_ns, gyro, accel: cdr.f64s()? })
    } else if topic == schema::LIDAR.name {
        Message::Scan(scan(&mut cdr, made_ns)?)
    } else if topic == schema::JOINTS.name {
        let (stamp_ns, _) = cdr.header()?;
        let names = cdr.length(5)?;
        for _ in 0..names {
            cdr.string()?;
        }
        Message::Joints(JointMessage { stamp_ns, positions: cdr.f64_list()? })
    } else if topic == schema::ODOMETRY.name {
        let (stamp_ns, _) = cdr.header()?;
        cdr.string()?;
        let position = cdr.f64s()?;
        let [x, y, z, w] = cdr.f64s()?;
        Message::Pose(PoseMessage { stamp_ns, position, quat: [w, x, y, z] })
    } else if topic == schema::STEP.name {
        Message::Step { to_strike_s: cdr.f64()? }
    } else if topic == schema::BELIEVED.name {
        return Ok(Some(Recorded::Believed { at_ns, bytes: data.to_vec() }));
    } else {
        return Ok(None);
    };
    Ok(Some(Recorded::Message(Arrived { at_ns, message })))
}

/// Reads bytes as a message of the topic that the first byte numbers, as a recording's reader does: for tests of damaged messages. Returns
/// whether they are one.
pub fn decode_any(bytes: &[u8]) -> bool {
    let Some((number, data)) = bytes.split_first() else { return false };
    let topic = schema::ALL[usize::from(*number) % schema::ALL.len()].name;
    let mut parts = Parts::default();
    decode(topic, 0, 0, data, &mut parts).is_ok()
}

fn camera(cdr: &mut CdrReader<'_>) -> Result<Intrinsics, Wrong> {
    cdr.header()?;
    let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
    cdr.string()?;
    cdr.f64_list()?;
    let [fx, _, cx, _, fy, cy, ..] = cdr.f64s::<9>()?;
    Ok(Intrinsics { width, height, focal: [fx, fy], center: [cx, cy] })
}

/// Time of capture `[ns]`, width, height and bytes of an image in this encoding.
fn image<'a>(
    cdr: &mut CdrReader<'a>,
    wanted: &str,
    bytes_a_pixel: usize,
) -> Result<(u64, [usize; 2], &'a [u8]), Wrong> {
    let (stamp_ns, _) = cdr.header()?;
    let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
    let encoding = cdr.string()?;
    let (big, step) = (cdr.u8()?, cdr.u32()? as usize);
    if encoding != wanted || big != 0 || step != bytes_a_pixel * width {
        let expected = format!("{wanted}, little-endian, {} bytes a row", bytes_a_pixel * width);
        return Err((expected, format!("{encoding}, is_bigendian {big}, {step} bytes a row")));
    }
    Ok((stamp_ns, [width, height], cdr.bytes()?))
}

fn color(cdr: &mut CdrReader<'_>) -> Result<(u64, ColorImage), Wrong> {
    let (stamp_ns, [width, height], bytes) = image(cdr, "rgb8", 3)?;
    let color = ColorImage::new(width, height, bytes.to_vec());
    Ok((stamp_ns, color.map_err(|error| ("a whole image".to_owned(), error.to_string()))?))
}

fn depth(cdr: &mut CdrReader<'_>) -> Result<DepthImage, Wrong> {
    let (_, [width, height], bytes) = image(cdr, "16UC1", 2)?;
    let data = bytes.chunks_exact(2).map(|b| u16::from_le_bytes([b[0], b[1]])).collect();
    DepthImage::new(width, height, data).map_err(|error| ("a whole image".to_owned(), error.to_string()))
}

fn scan(cdr: &mut CdrReader<'_>, end_ns: u64) -> Result<ScanMessage, Wrong> {
    let (start_ns, _) = cdr.header()?;
    cdr.u32()?;
    cdr.u32()?;
    let mut fields = Vec::new();
    for _ in 0..cdr.length(13)? {
        fields.push((cdr.string()?, cdr.u32()?, cdr.u8()?, cdr.u32()?));
    }
    let wanted =
        ["x", "y", "z", "t"].iter().enumerate().map(|(k, name)| ((*name).to_owned(), 8 * k as u32, 8, 1));
    if !fields.iter().cloned().eq(wanted) {
        return Err(("fields x, y, z, t as FLOAT64".to_owned(), format!("{fields:?}")));
    }
    cdr.u8()?;
    cdr.u32()?;
    cdr.u32()?;
    let points = cdr.bytes()?.chunks_exact(32).map(|point| {
        [0, 1, 2, 3].map(|k| {
            let mut number = [0; 8];
            number.copy_from_slice(&point[8 * k..8 * k + 8]);
            f64::from_le_bytes(number)
        })
    });
    Ok(ScanMessage { start_ns, end_ns, points: points.collect() })
}
