//! The images that went worst, side by side.

use super::framed;
use crate::{ColorImage, PixelBox};

/// An image with a ball that was not found, or with something that was taken for one.
#[derive(Clone, Debug, PartialEq)]
pub struct Bad {
    /// Number of the scene.
    pub number: u32,
    /// The image.
    pub picture: ColorImage,
    /// Outline of the ball that was missed.
    pub missed: Option<PixelBox>,
    /// What was taken for a ball.
    pub invented: Vec<PixelBox>,
}

/// Keeps the worst.
pub(super) struct Worst {
    kept: Vec<(f64, Bad)>,
    most: usize,
}

impl Worst {
    pub(super) fn new(most: usize) -> Self {
        Self { kept: Vec::new(), most }
    }

    pub(super) fn add(&mut self, badness: f64, make: impl FnOnce() -> Bad) {
        let place = self.kept.partition_point(|(b, _)| *b >= badness);
        if place < self.most {
            self.kept.insert(place, (badness, make()));
            self.kept.truncate(self.most);
        }
    }

    pub(super) fn into_sorted(self) -> Vec<Bad> {
        self.kept.into_iter().map(|(_, bad)| bad).collect()
    }
}

/// A sheet of images, `columns` in a row: missed balls in green frames, invented ones in red frames. `None` of none.
pub fn sheet(worst: &[Bad], columns: usize) -> Option<ColorImage> {
    let first = worst.first()?;
    let columns = columns.clamp(1, worst.len());
    let gap = 4;
    let [w, h] = [first.picture.width + gap, first.picture.height + gap];
    let mut out = ColorImage::filled(columns * w + gap, worst.len().div_ceil(columns) * h + gap, [255; 3]);
    for (k, bad) in worst.iter().enumerate() {
        let missed = bad.missed.iter().map(|b| (*b, [0, 255, 0]));
        let boxes: Vec<_> = missed.chain(bad.invented.iter().map(|b| (*b, [255, 0, 0]))).collect();
        let picture = framed(&bad.picture, &boxes);
        let corner = [k % columns * w + gap, k / columns * h + gap];
        for y in 0..picture.height {
            for x in 0..picture.width {
                out.set((corner[0] + x) as i64, (corner[1] + y) as i64, picture.get(x, y));
            }
        }
    }
    Some(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_pictures_come_first_and_no_more_than_asked() {
        let bad = |number: u32| Bad {
            number,
            picture: ColorImage::filled(8, 6, [number as u8; 3]),
            missed: Some(PixelBox { min: [3.0, 3.0], max: [4.0, 4.0] }),
            invented: Vec::new(),
        };
        let mut worst = Worst::new(3);
        for (badness, number) in [(0.4, 1), (1.9, 2), (0.2, 3), (0.9, 4), (0.5, 5)] {
            worst.add(badness, || bad(number));
        }
        let kept = worst.into_sorted();
        assert_eq!(kept.iter().map(|b| b.number).collect::<Vec<_>>(), [2, 4, 5]);
        let image = sheet(&kept, 2).expect("three images");
        assert_eq!((image.width, image.height), (2 * 12 + 4, 2 * 10 + 4));
        // The first image's corner, and its frame.
        assert_eq!((image.get(4, 4), image.get(5, 5)), ([2; 3], [0, 255, 0]));
        assert_eq!(sheet(&[], 2), None);
    }
}
