//! Whether a camera's pictures can be trusted: black, frozen, torn, without depth, of another camera, out of time.

use std::fmt;

use crate::{ColorImage, DepthImage, Intrinsics};

/// What is wrong with a picture. A ball is looked for only where [`PictureFault::is_blind`] is false.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PictureFault {
    /// Nothing but darkness.
    Black {
        /// The mean of all bytes, 0 to 255.
        mean: f64,
    },
    /// Everything of one color: a covered lens, a driver that fills in.
    Uniform {
        /// The standard deviation of all bytes.
        deviation: f64,
    },
    /// Byte for byte the picture before: sensors have noise.
    Frozen {
        /// How many in a row.
        pictures: u32,
    },
    /// A part of the rows is the picture before or of one color: it was cut off on its way.
    Torn {
        /// How many rows of its end.
        rows: usize,
    },
    /// Color or depth is not of the size that the camera's intrinsics say.
    Size {
        /// Width and height that were expected `[px]`.
        expected: [usize; 2],
        /// And found.
        found: [usize; 2],
    },
    /// The intrinsics are not those that the robot was set up with.
    Intrinsics {
        /// Focal length across that was expected `[px]`.
        expected: f64,
        /// And found.
        found: f64,
    },
    /// It was taken before or with the one before.
    TimeBackwards {
        /// By so much `[s]`.
        by_s: f64,
    },
    /// It came later than any picture is used, or from the future.
    Time {
        /// Its age at its arrival `[s]`.
        age_s: f64,
    },
    /// The depth picture knows nothing. The color picture is used.
    NoDepth,
}

impl PictureFault {
    /// Whether no ball may be looked for in the picture.
    pub fn is_blind(&self) -> bool {
        !matches!(self, Self::NoDepth)
    }
}

impl fmt::Display for PictureFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Black { mean } => write!(f, "picture black: mean {mean:.1} of 255, expected 6 or more"),
            Self::Uniform { deviation } => {
                write!(f, "picture of one color: deviation {deviation:.1} of 255, expected 2 or more")
            }
            Self::Frozen { pictures } => write!(f, "picture frozen: {pictures} equal ones in a row"),
            Self::Torn { rows } => write!(f, "picture torn: its last {rows} rows are not of it"),
            Self::Size { expected: [w, h], found: [x, y] } => {
                write!(f, "picture of {x} x {y} pixels, expected {w} x {h} as in the intrinsics")
            }
            Self::Intrinsics { expected, found } => {
                write!(f, "intrinsics: focal length {found:.1} px, expected {expected:.1} px within 2%")
            }
            Self::TimeBackwards { by_s } => {
                write!(f, "picture taken {by_s:.3} s before the one before it, expected a later time")
            }
            Self::Time { age_s } => write!(f, "picture {age_s:.3} s old, expected 0 to 0.5 s"),
            Self::NoDepth => write!(f, "depth unknown in the whole picture"),
        }
    }
}

/// Watches the pictures of one camera.
#[derive(Clone, Debug)]
pub struct PictureWatch {
    intrinsics: Intrinsics,
    last: Option<ColorImage>,
    last_s: Option<f64>,
    equal: u32,
}

/// A picture darker than this shows nothing.
const DARKEST: f64 = 6.0;
/// Deviation of the bytes of a picture that shows something.
const LEAST_DEVIATION: f64 = 2.0;
/// Pictures are used up to this age `[s]`.
const OLDEST_S: f64 = 0.5;
/// Clocks of camera and computer may differ by so much `[s]`.
const FUTURE_S: f64 = 0.005;
/// Time that runs back by more is a clock that was set `[s]`.
const SET_CLOCK_S: f64 = 1.0;
/// Focal lengths may differ by this share.
const FOCAL_SHARE: f64 = 0.02;
/// Rows at the end that make a picture torn.
const TORN_ROWS: usize = 8;

impl PictureWatch {
    /// For a camera that the robot was set up with.
    pub fn new(intrinsics: Intrinsics) -> Self {
        Self { intrinsics, last: None, last_s: None, equal: 0 }
    }

    /// Looks at a picture that was taken at `captured_s` and came at `now_s` `[s]`, with the intrinsics that came with it.
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
                // The clock was set: it is said once, and the next picture is taken.
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
        let result = self.content(color);
        self.last = Some(color.clone());
        result?;
        match depth {
            Some(depth) if depth.data.iter().all(|mm| *mm == 0) => Err(PictureFault::NoDepth),
            _ => Ok(()),
        }
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
    use super::*;

    fn camera() -> Intrinsics {
        Intrinsics::from_angles(40, 30, 69.0, 42.0)
    }

    /// A picture with noise of its own.
    fn picture(number: u32) -> ColorImage {
        let mut state = number.wrapping_mul(0x9e37_79b9) | 1;
        let data = (0..3 * 40 * 30).map(|_| {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            80 + (state >> 26) as u8
        });
        ColorImage::new(40, 30, data.collect()).expect("whole")
    }

    fn depth(mm: u16) -> DepthImage {
        DepthImage::new(40, 30, vec![mm; 40 * 30]).expect("whole")
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
        assert_eq!(error, "picture taken 0.100 s before the one before it, expected a later time");
        let error = look(2.0, 1.9, &camera(), 3).expect_err("from the future");
        assert_eq!(error, "picture -0.100 s old, expected 0 to 0.5 s");
        let other = Intrinsics::from_angles(40, 30, 87.0, 58.0);
        let error = look(2.0, 2.05, &other, 4).expect_err("the depth camera's");
        assert!(error.starts_with("intrinsics: focal length 21.1 px, expected 29.1 px"), "{error}");
        assert_eq!(look(2.1, 2.15, &camera(), 5), Ok(()));
    }
}
