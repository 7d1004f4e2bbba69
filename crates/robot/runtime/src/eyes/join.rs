//! Color, depth and camera of one moment, from three topics.

use std::collections::VecDeque;

use paid_vision::{ColorImage, DepthImage, Intrinsics};
use paid_world::PictureMessage;
use paid_world::ros::Stamped;

/// Stamps of a color image and its depth may differ by this much `[ns]`: half an image at 30 Hz. Drivers that do not trigger both at once
/// stamp them a few milliseconds apart.
const APART_NS: u64 = 17_000_000;
/// A color image waits this long for its depth `[ns]`.
const PATIENCE_NS: u64 = 50_000_000;
/// Depth images that wait for their color.
const DEPTHS: usize = 4;

/// Puts images together. Only the newest counts: one that was not taken is replaced by the next.
#[derive(Debug, Default)]
pub struct PictureJoiner {
    frame: String,
    camera: Option<Intrinsics>,
    color: Option<Stamped<ColorImage>>,
    /// When the oldest color image came since the last one was given `[ns]`: a newer one that takes its place does not restart the wait.
    since_ns: Option<u64>,
    /// Stamp of the last color image, if it was given alone `[ns]`: the next ones do not wait, until a depth image comes that fits it.
    alone_ns: Option<u64>,
    depths: VecDeque<Stamped<DepthImage>>,
}

impl PictureJoiner {
    /// For messages that name this frame; empty: any.
    pub fn new(frame: &str) -> Self {
        Self { frame: frame.to_owned(), ..Self::default() }
    }

    fn check<T>(&self, what: &str, stamped: &Stamped<T>) -> Result<(), String> {
        if self.frame.is_empty() || stamped.frame == self.frame {
            return Ok(());
        }
        Err(format!("{what}: expected the frame {}, found '{}'", self.frame, stamped.frame))
    }

    /// Takes in a camera.
    ///
    /// # Errors
    /// If it is of another frame.
    pub fn info(&mut self, camera: &Stamped<Intrinsics>) -> Result<(), String> {
        self.check("camera info", camera)?;
        self.camera = Some(camera.value);
        Ok(())
    }

    /// Takes in a depth image.
    ///
    /// # Errors
    /// If it is of another frame: not aligned to color.
    pub fn depth(&mut self, depth: Stamped<DepthImage>) -> Result<(), String> {
        self.check("depth image", &depth)?;
        if self.alone_ns.is_some_and(|stamp| depth.stamp_ns.abs_diff(stamp) <= APART_NS) {
            self.alone_ns = None;
        }
        if self.depths.len() >= DEPTHS {
            self.depths.pop_front();
        }
        self.depths.push_back(depth);
        Ok(())
    }

    /// Takes in a color image that came at `at_ns` `[ns]`.
    ///
    /// # Errors
    /// If it is of another frame, or no camera has come before it.
    pub fn color(&mut self, color: Stamped<ColorImage>, at_ns: u64) -> Result<(), String> {
        self.check("color image", &color)?;
        if self.camera.is_none() {
            return Err("color image: expected a camera info before it, found none".to_owned());
        }
        self.color = Some(color);
        self.since_ns.get_or_insert(at_ns);
        Ok(())
    }

    /// The newest image that is whole, or has waited too long for its depth, at `now_ns` `[ns]`; its time of capture is the stamp.
    pub fn take(&mut self, now_ns: u64) -> Option<PictureMessage> {
        let stamp = self.color.as_ref()?.stamp_ns;
        let camera = self.camera?;
        let waited_ns = now_ns.saturating_sub(self.since_ns.unwrap_or(now_ns));
        let nearest = self.depths.iter().enumerate().min_by_key(|(_, depth)| depth.stamp_ns.abs_diff(stamp));
        let found = nearest.filter(|(_, depth)| depth.stamp_ns.abs_diff(stamp) <= APART_NS).map(|(k, _)| k);
        if found.is_none() && self.alone_ns.is_none() && waited_ns < PATIENCE_NS {
            return None;
        }
        self.alone_ns = found.is_none().then_some(stamp);
        self.since_ns = None;
        let depth = found.and_then(|k| self.depths.drain(..=k).next_back()).map(|depth| depth.value);
        let color = self.color.take()?;
        Some(PictureMessage {
            captured_ns: color.stamp_ns,
            color: color.value,
            depth,
            intrinsics: camera,
            boxes: None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MS: u64 = 1_000_000;

    fn stamped<T>(ms: u64, value: T) -> Stamped<T> {
        Stamped { stamp_ns: ms * MS, frame: "eye".to_owned(), value }
    }

    fn joiner() -> PictureJoiner {
        let mut joiner = PictureJoiner::new("eye");
        joiner.info(&stamped(0, Intrinsics::from_angles(1, 1, 60.0, 60.0))).expect("a camera");
        joiner
    }

    fn color(ms: u64) -> Stamped<ColorImage> {
        stamped(ms, ColorImage::filled(1, 1, [ms as u8; 3]))
    }

    fn depth(ms: u64) -> Stamped<DepthImage> {
        stamped(ms, DepthImage::new(1, 1, vec![ms as u16]).expect("whole"))
    }

    #[test]
    fn a_picture_waits_for_the_depth_of_its_moment() {
        let mut joiner = joiner();
        joiner.depth(depth(60)).expect("depth");
        joiner.color(color(100), 130 * MS).expect("color");
        assert!(joiner.take(131 * MS).is_none(), "the depth is 40 ms older");
        joiner.depth(depth(104)).expect("depth");
        let picture = joiner.take(135 * MS).expect("an image");
        assert_eq!((picture.captured_ns, picture.depth.map(|d| d.data)), (100 * MS, Some(vec![104])));
        assert!(joiner.take(200 * MS).is_none(), "it was taken");
    }

    #[test]
    fn without_its_depth_it_is_given_alone_and_a_newer_one_takes_its_place() {
        let mut joiner = joiner();
        joiner.color(color(100), 130 * MS).expect("color");
        joiner.color(color(140), 170 * MS).expect("color");
        assert!(joiner.take(179 * MS).is_none());
        let picture = joiner.take(180 * MS).expect("50 ms after the first one");
        assert_eq!((picture.captured_ns, picture.depth), (140 * MS, None));
    }

    #[test]
    fn at_30_hz_without_depth_only_the_first_picture_waits_until_depth_comes_again() {
        let mut joiner = joiner();
        let mut given = Vec::new();
        for ms in 0..200_u64 {
            if ms.is_multiple_of(33) {
                joiner.color(color(ms), ms * MS).expect("color");
            }
            let picture = joiner.take(ms * MS);
            given.extend(picture.map(|picture| (ms, picture.captured_ns / MS, picture.depth.is_some())));
        }
        let at_once = [66_u64, 99, 132, 165, 198].map(|ms| (ms, ms, false));
        assert_eq!((given[0], &given[1..]), ((50, 33, false), at_once.as_slice()));
        // The depth of the last one, too late for it.
        joiner.depth(depth(198)).expect("depth");
        joiner.color(color(231), 231 * MS).expect("color");
        assert!(joiner.take(231 * MS).is_none(), "it waits");
        joiner.depth(depth(233)).expect("depth");
        let picture = joiner.take(240 * MS).expect("an image");
        assert_eq!((picture.captured_ns, picture.depth.map(|d| d.data)), (231 * MS, Some(vec![233])));
    }

    #[test]
    fn another_frame_or_a_picture_before_its_camera_is_refused() {
        let mut joiner = joiner();
        let other = Stamped { frame: "camera_depth_optical_frame".to_owned(), ..depth(1) };
        let error = joiner.depth(other).expect_err("not aligned");
        assert_eq!(error, "depth image: expected the frame eye, found 'camera_depth_optical_frame'");
        let error = PictureJoiner::new("").color(color(1), 0).expect_err("no camera yet");
        assert!(error.contains("expected a camera info"), "{error}");
    }
}
