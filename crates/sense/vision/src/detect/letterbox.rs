//! An image in the size and order that a network wants.

use super::Depth;
use crate::net::depth_code;
use crate::{ColorImage, PixelBox};

/// The gray around an image of another shape; detectors are trained with it.
const GRAY: f32 = 114.0;

/// Where the image lies in the network's input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// In the middle (YOLOv8 and the project's network).
    Middle,
    /// At the top left corner (YOLOX).
    TopLeft,
}

/// What the numbers of the input mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coding {
    /// Red, green, blue, 0 to 1.
    RgbUnit,
    /// Blue, green, red, 0 to 255.
    BgrBytes,
}

/// How an image was fitted into a network's input: `input = scale image + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Letterbox {
    /// Pixels of the input per pixel of the image.
    pub scale: f64,
    /// Left and upper edge of the image in the input `[px]`.
    pub offset: [f64; 2],
}

impl Letterbox {
    /// Fits an image of this size into an input of that size, as large as it goes without changing its shape.
    pub fn fit(picture: [usize; 2], input: [usize; 2], anchor: Anchor) -> Self {
        let ratio = |k: usize| input[k] as f64 / picture[k] as f64;
        let scale = ratio(0).min(ratio(1));
        let offset = [0, 1].map(|k| match anchor {
            // Whole pixels: the gray bars are exact.
            Anchor::Middle => (0.5 * (input[k] as f64 - (picture[k] as f64 * scale).round())).floor(),
            Anchor::TopLeft => 0.0,
        });
        Self { scale, offset }
    }

    /// A box of the input in the image.
    pub fn to_picture(&self, input: &PixelBox) -> PixelBox {
        let back = |p: [f64; 2]| [0, 1].map(|k| (p[k] - self.offset[k]) / self.scale);
        PixelBox { min: back(input.min), max: back(input.max) }
    }

    /// A point of the image in the input.
    pub fn to_input(&self, picture: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| picture[k].mul_add(self.scale, self.offset[k]))
    }

    /// The input `[3, height, width]` (`input` is width, height).
    ///
    /// A smaller image is read by the mean over what a pixel of the input covers, a larger one between four pixels.
    pub fn fill(&self, picture: &ColorImage, input: [usize; 2], coding: Coding) -> Vec<f32> {
        let [width, height] = input;
        let plane = width * height;
        let (factor, order) = match coding {
            Coding::RgbUnit => (1.0 / 255.0, [0, 1, 2]),
            Coding::BgrBytes => (1.0, [2, 1, 0]),
        };
        let mut out = vec![GRAY * factor; 3 * plane];
        let columns = Taps::of(self.scale, self.offset[0], picture.width, width);
        let rows = Taps::of(self.scale, self.offset[1], picture.height, height);
        // Across first: one line of the image after the other.
        let mut lines = vec![0.0_f32; 3 * width * picture.height];
        for (y, line) in lines.chunks_exact_mut(3 * width).enumerate() {
            let row = &picture.data[3 * y * picture.width..3 * (y + 1) * picture.width];
            for (x, taps) in columns.taps.iter().enumerate() {
                let mut sum = [0.0_f32; 3];
                for (k, weight) in taps.weights.iter().enumerate() {
                    let pixel = &row[3 * (taps.first + k)..3 * (taps.first + k) + 3];
                    for c in 0..3 {
                        sum[c] += weight * f32::from(pixel[c]);
                    }
                }
                line[3 * x..3 * x + 3].copy_from_slice(&sum);
            }
        }
        for (y, taps) in rows.taps.iter().enumerate() {
            for (x, across) in columns.taps.iter().enumerate() {
                if taps.weights.is_empty() || across.weights.is_empty() {
                    continue;
                }
                let mut sum = [0.0_f32; 3];
                for (k, weight) in taps.weights.iter().enumerate() {
                    let at = 3 * ((taps.first + k) * width + x);
                    for c in 0..3 {
                        sum[c] += weight * lines[at + c];
                    }
                }
                for c in 0..3 {
                    out[order[c] * plane + y * width + x] = sum[c] * factor;
                }
            }
        }
        out
    }

    /// The depth channel of the project's network, `[height, width]`: each pixel of the input reads the pixel of the image under its
    /// middle. Depths are not averaged: between a ball and the floor behind it there is nothing.
    pub(super) fn fill_depth(&self, depth: Option<Depth<'_>>, [width, height]: [usize; 2]) -> Vec<f32> {
        let mut out = vec![0.0; width * height];
        let Some(Depth { image, intrinsics }) = depth else { return out };
        let focal = intrinsics.focal[0] * self.scale;
        let under = |i: usize, k: usize, size: usize| {
            let at = (i as f64 + 0.5 - self.offset[k]) / self.scale;
            (at >= 0.0 && at < size as f64).then_some(at as usize)
        };
        let columns: Vec<Option<usize>> = (0..width).map(|x| under(x, 0, image.width)).collect();
        for (y, line) in out.chunks_exact_mut(width).enumerate() {
            let Some(row) = under(y, 1, image.height) else { continue };
            for (value, column) in line.iter_mut().zip(&columns) {
                if let Some(column) = column {
                    *value = depth_code(image.data[row * image.width + column], focal);
                }
            }
        }
        out
    }
}

/// Which pixels of a line make one pixel of the input, and their shares; none outside the image.
struct Tap {
    first: usize,
    weights: Vec<f32>,
}

struct Taps {
    taps: Vec<Tap>,
}

impl Taps {
    fn of(scale: f64, offset: f64, picture: usize, input: usize) -> Self {
        let filled = (picture as f64 * scale).round();
        // Half the width of what is read: a pixel of the input, or a pixel of the image if that is larger.
        let reach = (1.0 / scale).max(1.0);
        let tap = |i: usize| {
            let at = i as f64 - offset;
            if at < 0.0 || at >= filled {
                return Tap { first: 0, weights: Vec::new() };
            }
            let middle = (at + 0.5) / scale - 0.5;
            let first = (middle - reach).ceil().max(0.0) as usize;
            let last = ((middle + reach).floor().max(0.0) as usize).min(picture - 1);
            let first = first.min(last);
            let weights: Vec<f64> =
                (first..=last).map(|p| (1.0 - (p as f64 - middle).abs() / reach).max(0.0)).collect();
            let sum: f64 = weights.iter().sum();
            if sum <= 0.0 {
                return Tap { first, weights: vec![1.0] };
            }
            Tap { first, weights: weights.iter().map(|w| (w / sum) as f32).collect() }
        };
        Self { taps: (0..input).map(tap).collect() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DepthImage, Intrinsics};

    #[test]
    fn a_wide_picture_gets_gray_bars_above_and_below() {
        let fit = Letterbox::fit([640, 360], [320, 192], Anchor::Middle);
        assert_eq!(fit, Letterbox { scale: 0.5, offset: [0.0, 6.0] });
        let picture = ColorImage::filled(640, 360, [255, 0, 51]);
        let input = fit.fill(&picture, [320, 192], Coding::RgbUnit);
        let at = |c: usize, x: usize, y: usize| input[c * 320 * 192 + y * 320 + x];
        assert!([at(0, 5, 5), at(1, 319, 186)].iter().all(|v| (v - 114.0 / 255.0).abs() < 1e-6));
        assert!(
            (at(0, 0, 6) - 1.0).abs() < 1e-6 && at(1, 319, 185) == 0.0 && (at(2, 9, 99) - 0.2).abs() < 1e-6
        );
        let back = fit.to_picture(&PixelBox { min: [10.0, 16.0], max: [20.0, 26.0] });
        assert_eq!((back.min, back.max), ([20.0, 20.0], [40.0, 40.0]));
        assert_eq!(fit.to_input(back.min), [10.0, 16.0]);
    }

    #[test]
    fn yolox_takes_blue_first_at_the_corner() {
        let fit = Letterbox::fit([2, 1], [4, 4], Anchor::TopLeft);
        assert_eq!(fit, Letterbox { scale: 2.0, offset: [0.0, 0.0] });
        let picture = ColorImage::filled(2, 1, [10, 20, 30]);
        let input = fit.fill(&picture, [4, 4], Coding::BgrBytes);
        assert_eq!([input[0], input[16], input[32], input[15]], [30.0, 20.0, 10.0, 114.0]);
    }

    #[test]
    fn depth_is_read_where_the_picture_lies() {
        let fit = Letterbox::fit([640, 360], [320, 192], Anchor::Middle);
        let intrinsics = Intrinsics { width: 640, height: 360, focal: [400.0; 2], center: [320.0, 180.0] };
        let mut image = DepthImage::new(640, 360, vec![1100; 640 * 360]).expect("whole");
        image.data[2 * (640 + 1) + 640 + 1] = 0;
        let input = fit.fill_depth(Some(Depth { image: &image, intrinsics: &intrinsics }), [320, 192]);
        let at = |x: usize, y: usize| input[y * 320 + x];
        // 0.22 m at 1.1 m and 200 px of the input: five cells. Pixel (1, 7) of the input reads pixel (3, 3) of the image.
        assert!((at(5, 100) - 0.5 * 5.0_f32.ln()).abs() < 1e-6);
        assert_eq!([at(5, 5), at(1, 7), at(5, 186)], [0.0; 3]);
        assert_eq!(fit.fill_depth(None, [320, 192]), vec![0.0; 320 * 192]);
    }

    #[test]
    fn a_smaller_input_is_the_mean_of_the_image() {
        // Stripes of one pixel become an even gray; nothing of them is left as a coarser pattern.
        let data = (0..64 * 64).flat_map(|i| [if i % 2 == 0 { 0 } else { 200 }; 3]).collect();
        let picture = ColorImage::new(64, 64, data).expect("whole");
        let fit = Letterbox::fit([64, 64], [16, 16], Anchor::Middle);
        let input = fit.fill(&picture, [16, 16], Coding::BgrBytes);
        assert!(input[..256].iter().all(|v| (v - 100.0).abs() < 15.0), "{:?}", &input[..16]);
    }
}
