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
    /// What to say if no image comes.
    pub silent: String,
    /// The readers live no longer than their network.
    _topics: RosTopics,
}

impl Camera {
    pub fn open(input: &CameraInput, topics: RosTopics) -> Result<Self, DeployError> {
        // Today's RealSense driver puts the camera's name into its topics.
        let renamed = input.color.starts_with("/camera/") && !input.color.starts_with("/camera/camera/");
        let hint = if renamed {
            " (today's RealSense driver has /camera/camera/color/image_raw and so on: set camera.color, camera.depth and camera.info)"
        } else {
            ""
        };
        let silent = format!("camera: no image for a second on {} and {}{hint}", input.color, input.depth);
        Ok(Self {
            silent,
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

    /// Local time of an image's stamp.
    pub fn captured_ns(&mut self, stamp_ns: u64, now_ns: u64) -> u64 {
        match self.clock {
            StampClock::System => of_system(stamp_ns, now_ns),
            StampClock::Own => self.own.local_ns(stamp_ns, now_ns).saturating_sub(self.latency_ns),
        }
    }
}
