//! A camera's topics.

use paid_world::SightError;
use paid_world::ros::{read_camera_info, read_color, read_depth};

use super::of_system;
use crate::DeployError;
use crate::eyes::{CameraInput, Desk, DeviceClock, PictureJoiner, StampClock};
use crate::ros::{CAMERA_INFO, IMAGE, RosReader, RosTopics};

/// A camera's topics.
pub(super) struct Camera {
    info: RosReader,
    depth: RosReader,
    color: RosReader,
    pub joiner: PictureJoiner,
    clock: StampClock,
    latency_ns: u64,
    own: DeviceClock,
    /// The topics of color and depth.
    names: [String; 2],
    /// The readers live no longer than their network.
    _topics: RosTopics,
}

impl Camera {
    pub fn open(input: &CameraInput, topics: RosTopics) -> Result<Self, DeployError> {
        Ok(Self {
            names: [&input.color, &input.depth].map(String::clone),
            info: topics.reader(&input.info, CAMERA_INFO, input.reliable)?,
            depth: topics.reader(&input.depth, IMAGE, input.reliable)?,
            color: topics.reader(&input.color, IMAGE, input.reliable)?,
            joiner: PictureJoiner::new(&input.frame),
            clock: input.clock,
            latency_ns: (input.latency_s * 1e9) as u64,
            own: DeviceClock::default(),
            _topics: topics,
        })
    }

    /// Everything that has come.
    pub fn read(&mut self, desk: &Desk) -> Result<(), String> {
        let words = |error: SightError| error.to_string();
        let mut first = Ok(());
        let mut note = |result: Result<(), String>| {
            if first.is_ok() {
                first = result;
            }
        };
        while let Some(bytes) = self.info.take().map_err(|e| e.to_string())? {
            note(read_camera_info(&bytes).map_err(words).and_then(|info| self.joiner.info(&info)));
        }
        while let Some(bytes) = self.depth.take().map_err(|e| e.to_string())? {
            note(read_depth(&bytes).map_err(words).and_then(|depth| self.joiner.depth(depth)));
        }
        while let Some(bytes) = self.color.take().map_err(|e| e.to_string())? {
            let now_ns = desk.now_ns();
            note(read_color(&bytes).map_err(words).and_then(|color| self.joiner.color(color, now_ns)));
        }
        first
    }

    /// What to say if no image has come for a second: on which topics nothing comes, and why.
    pub fn silent(&self) -> String {
        let [color, depth] = &self.names;
        let why: Vec<String> =
            [&self.color, &self.depth, &self.info].into_iter().filter_map(RosReader::silent).collect();
        let why = if why.is_empty() { String::new() } else { format!(": {}", why.join("; ")) };
        format!("camera: no image for a second on {color} and {depth}{why}")
    }

    /// Local time of an image's stamp.
    pub fn captured_ns(&mut self, stamp_ns: u64, now_ns: u64) -> u64 {
        match self.clock {
            StampClock::System => of_system(stamp_ns, now_ns),
            StampClock::Own => self.own.local_ns(stamp_ns, now_ns).saturating_sub(self.latency_ns),
        }
    }
}
