//! Whether a camera's images can be trusted: black, frozen, torn, without depth or with an old one, of another camera, out of time.

use crate::{ColorImage, DepthImage, Intrinsics, PictureFault};

/// Watches the images of one camera.
#[derive(Clone, Debug)]
pub struct PictureWatch {
    intrinsics: Intrinsics,
    last: Option<ColorImage>,
    last_s: Option<f64>,
    equal: u32,
    last_depth: Option<DepthImage>,
    equal_depths: u32,
}

/// An image darker than this shows nothing.
const DARKEST: f64 = 6.0;
/// Deviation of the bytes of an image that shows something.
const LEAST_DEVIATION: f64 = 2.0;
/// Images are used up to this age `[s]`.
const OLDEST_S: f64 = 0.5;
/// Clocks of camera and computer may differ by this much `[s]`.
const FUTURE_S: f64 = 0.005;
/// Time that runs back by more is a clock that was set `[s]`.
const SET_CLOCK_S: f64 = 1.0;
/// Focal lengths may differ by this share.
const FOCAL_SHARE: f64 = 0.02;
/// The optical axis may be elsewhere by this share of the image's width: a quarter to a half of a degree.
const CENTER_SHARE: f64 = 0.01;
/// Rows at the end that make an image torn.
const TORN_ROWS: usize = 8;

impl PictureWatch {
    /// For a camera that the robot was set up with.
    pub fn new(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, last: None, last_s: None, equal: 0, last_depth: None, equal_depths: 0 }
    }

    /// Looks at an image that was taken at `captured_s` and came at `now_s` `[s]`, with the intrinsics that came with it.
    ///
    /// # Errors
    /// The first fault.
    pub fn check(
        &mut self,
        color: &ColorImage,
        depth: Option<&DepthImage>,
        intrinsics: &Intrinsics,
        captured_s: f64,
        now_s: f64,
    ) -> Result<(), PictureFault> {
        let age_s = now_s - captured_s;
        if !(-FUTURE_S..=OLDEST_S).contains(&age_s) {
            return Err(PictureFault::Time { age_s });
        }
        if let Some(last_s) = self.last_s
            && captured_s <= last_s
        {
            let by_s = last_s - captured_s;
            if by_s > SET_CLOCK_S {
                // The clock was set: it is reported once, and the next image is taken.
                self.last_s = Some(captured_s);
            }
            return Err(PictureFault::TimeBackwards { by_s });
        }
        self.last_s = Some(captured_s);
        let expected = [self.intrinsics.width, self.intrinsics.height];
        let sizes = [Some([color.width, color.height]), depth.map(|d| [d.width, d.height])];
        if let Some(found) = sizes.into_iter().flatten().find(|found| *found != expected) {
            return Err(PictureFault::Size { expected, found });
        }
        for k in 0..2 {
            let (expected, found) = (self.intrinsics.focal[k], intrinsics.focal[k]);
            let share = (found / expected - 1.0).abs();
            if share.is_nan() || share > FOCAL_SHARE {
                return Err(PictureFault::Intrinsics { expected, found });
            }
        }
        let (expected, found) = (self.intrinsics.center, intrinsics.center);
        let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        if off.is_nan() || off > CENTER_SHARE * self.intrinsics.width as f64 {
            return Err(PictureFault::Center { expected, found });
        }
        let content = self.content(color);
        self.last = Some(color.clone());
        let depth_content = depth.map_or(Ok(()), |depth| self.depth_content(depth));
        self.last_depth = depth.cloned();
        content.and(depth_content)
    }

    fn depth_content(&mut self, depth: &DepthImage) -> Result<(), PictureFault> {
        if depth.data.iter().all(|mm| *mm == 0) {
            return Err(PictureFault::NoDepth);
        }
        // Rows of zeros know nothing and do no harm: the ground may be nearer than the camera sees.
        let is_flat = |row: &[u16]| row.iter().all(|mm| *mm == row[0]);
        let rows = || depth.data.chunks_exact(depth.width).rev();
        if let Some(last) = &self.last_depth {
            if last.data == depth.data {
                self.equal_depths += 1;
                return Err(PictureFault::DepthFrozen { pictures: self.equal_depths + 1 });
            }
            let pairs = rows().zip(last.data.chunks_exact(last.width).rev());
            let same = pairs.take_while(|(now, before)| now == before && !is_flat(now)).count();
            if same >= TORN_ROWS {
                return Err(PictureFault::DepthTorn { rows: same });
            }
        }
        self.equal_depths = 0;
        let flat = rows().take_while(|row| is_flat(row) && row[0] != 0).count();
        if flat >= TORN_ROWS { Err(PictureFault::DepthTorn { rows: flat }) } else { Ok(()) }
    }

    fn content(&mut self, color: &ColorImage) -> Result<(), PictureFault> {
        let row = 3 * color.width;
        if let Some(last) = &self.last {
            if last.data == color.data {
                self.equal += 1;
                return Err(PictureFault::Frozen { pictures: self.equal + 1 });
            }
            let pairs = color.data.chunks_exact(row).rev().zip(last.data.chunks_exact(row).rev());
            let rows = pairs.take_while(|(now, before)| now == before && !is_flat(now)).count();
            if rows >= TORN_ROWS {
                return Err(PictureFault::Torn { rows });
            }
        }
        self.equal = 0;
        let count = color.data.len() as f64;
        let mean = color.data.iter().map(|v| f64::from(*v)).sum::<f64>() / count;
        if mean < DARKEST {
            return Err(PictureFault::Black { mean });
        }
        let deviation =
            (color.data.iter().map(|v| (f64::from(*v) - mean).powi(2)).sum::<f64>() / count).sqrt();
        if deviation < LEAST_DEVIATION {
            return Err(PictureFault::Uniform { deviation });
        }
        let rows = color.data.chunks_exact(row).rev().take_while(|row| is_flat(row)).count();
        if rows >= TORN_ROWS { Err(PictureFault::Torn { rows }) } else { Ok(()) }
    }
}

/// Whether a row is of one color.
fn is_flat(row: &[u8]) -> bool {
    row.chunks_exact(3).all(|pixel| pixel == &row[..3])
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicU16, Ordering};

    use super::*;

    fn camera() -> Intrinsics {
        Intrinsics::from_angles(40, 30, 69.0, 42.0)
    }

    /// An image with noise of its own.
    fn picture(number: u32) -> ColorImage {
        let mut state = number.wrapping_mul(0x9e37_79b9) | 1;
        let data = (0..3 * 40 * 30).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            80 + (state >> 26) as u8
        });
        ColorImage::new(40, 30, data.collect()).expect("whole")
    }

    /// Depths that differ from pixel to pixel and from call to call; 0 knows none.
    fn depth(mm: u16) -> DepthImage {
        static CALLS: AtomicU16 = AtomicU16::new(0);
        let call = CALLS.fetch_add(1, Ordering::Relaxed) % 50;
        let noisy = |i: u16| if mm == 0 { 0 } else { mm + (i * 7 + call * 3) % 11 };
        DepthImage::new(40, 30, (0..40 * 30).map(noisy).collect()).expect("whole")
    }

    #[test]
    fn depth_that_stands_still_or_is_cut_is_not_used_and_color_is() {
        let mut watch = PictureWatch::new(camera());
        let mut time_s = 0.0;
        let mut look = |depth: &DepthImage| {
            time_s += 0.03;
            let color = picture((1000.0 * time_s) as u32);
            watch.check(&color, Some(depth), &camera(), time_s, time_s + 0.06)
        };
        let [first, second, third] = [depth(900), depth(900), depth(900)];
        assert_eq!(look(&first), Ok(()));
        assert_eq!(look(&first), Err(PictureFault::DepthFrozen { pictures: 2 }));
        assert_eq!(look(&first), Err(PictureFault::DepthFrozen { pictures: 3 }));
        assert_eq!(look(&second), Ok(()));
        let mut torn = third.clone();
        torn.data[40 * 18..].copy_from_slice(&second.data[40 * 18..]);
        assert_eq!(look(&torn), Err(PictureFault::DepthTorn { rows: 12 }));
        let mut filled = first.clone();
        filled.data[40 * 20..].fill(1200);
        let fault = look(&filled).expect_err("a driver that fills in");
        assert_eq!(fault.to_string(), "depth torn: its last 10 rows are from another image");
        assert!(!fault.is_blind() && !PictureFault::DepthFrozen { pictures: 2 }.is_blind());
        // The ground is too near to be seen.
        let mut near = third.clone();
        near.data[40 * 20..].fill(0);
        assert_eq!(look(&near), Ok(()));
    }

    #[test]
    fn each_fault_has_its_name_and_the_next_good_picture_is_taken() {
        let mut watch = PictureWatch::new(camera());
        let mut time_s = 0.0;
        let mut look = |color: &ColorImage, mm: u16| {
            time_s += 0.03;
            watch.check(color, Some(&depth(mm)), &camera(), time_s, time_s + 0.06)
        };
        assert_eq!(look(&picture(1), 900), Ok(()));
        assert_eq!(look(&picture(1), 900), Err(PictureFault::Frozen { pictures: 2 }));
        assert_eq!(look(&picture(1), 900), Err(PictureFault::Frozen { pictures: 3 }));
        assert_eq!(look(&picture(2), 900), Ok(()));
        let mut torn = picture(3);
        torn.data[3 * 40 * 18..].copy_from_slice(&picture(2).data[3 * 40 * 18..]);
        assert_eq!(look(&torn, 900), Err(PictureFault::Torn { rows: 12 }));
        let mut cut = picture(4);
        cut.data[3 * 40 * 20..].fill(0);
        assert_eq!(look(&cut, 900), Err(PictureFault::Torn { rows: 10 }));
        assert_eq!(look(&ColorImage::filled(40, 30, [2; 3]), 900), Err(PictureFault::Black { mean: 2.0 }));
        let gray = look(&ColorImage::filled(40, 30, [90; 3]), 900);
        assert_eq!(gray, Err(PictureFault::Uniform { deviation: 0.0 }));
        let no_depth = look(&picture(5), 0);
        assert_eq!(no_depth, Err(PictureFault::NoDepth));
        assert!(!PictureFault::NoDepth.is_blind());
        let small = ColorImage::filled(20, 30, [90; 3]);
        assert_eq!(look(&small, 900), Err(PictureFault::Size { expected: [40, 30], found: [20, 30] }));
        assert_eq!(look(&picture(6), 900), Ok(()));
    }

    #[test]
    fn times_and_intrinsics_that_cannot_be_are_refused_with_what_was_found() {
        let mut watch = PictureWatch::new(camera());
        let mut look = |captured_s: f64, now_s: f64, camera: &Intrinsics, number: u32| {
            watch.check(&picture(number), None, camera, captured_s, now_s).map_err(|fault| fault.to_string())
        };
        assert_eq!(look(1.0, 1.06, &camera(), 1), Ok(()));
        let error = look(0.9, 1.0, &camera(), 2).expect_err("time runs back");
        assert_eq!(error, "image taken 0.100 s before the one before it, expected a later time");
        let error = look(2.0, 1.9, &camera(), 3).expect_err("from the future");
        assert_eq!(error, "image -0.100 s old, expected 0 to 0.5 s");
        let other = Intrinsics::from_angles(40, 30, 87.0, 58.0);
        let error = look(2.0, 2.05, &other, 4).expect_err("the depth camera's");
        assert!(error.starts_with("intrinsics: focal length 21.1 px, expected 29.1 px"), "{error}");
        let mut moved = camera();
        moved.center[0] += 0.5;
        let error = look(2.05, 2.1, &moved, 5).expect_err("0.5 px of 40 px");
        assert_eq!(
            error,
            "intrinsics: optical axis at (20.5, 15.0) px, expected (20.0, 15.0) px within 1% of the width"
        );
        moved.center[0] -= 0.2;
        assert_eq!(look(2.1, 2.15, &moved, 6), Ok(()));
    }
}
