//! Pixels: rectangles, lines, text, PNG.

use std::path::Path;

use paid_files::{FileError, write_whole};

use crate::PlotError;
use crate::font::Letters;

/// Red, green, blue.
pub type Rgb = [u8; 3];

/// An image; (0, 0) is the top left pixel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Canvas {
    width: usize,
    height: usize,
    pixels: Vec<Rgb>,
}

impl Canvas {
    /// An image of one color.
    pub fn new(width: usize, height: usize, background: Rgb) -> Self {
        Self { width, height, pixels: vec![background; width * height] }
    }
    /// Pixels from left to right.
    pub fn width(&self) -> usize {
        self.width
    }
    /// Pixels from top to bottom.
    pub fn height(&self) -> usize {
        self.height
    }
    /// The color of a pixel inside the image.
    pub fn get(&self, x: usize, y: usize) -> Rgb {
        self.pixels[y * self.width + x]
    }
    /// Sets a pixel; outside the image nothing happens.
    pub fn set(&mut self, x: i64, y: i64, color: Rgb) {
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < self.width
            && y < self.height
        {
            self.pixels[y * self.width + x] = color;
        }
    }
    /// Fills a rectangle.
    pub fn rect(&mut self, x: i64, y: i64, width: i64, height: i64, color: Rgb) {
        for py in y..y + height {
            for px in x..x + width {
                self.set(px, py, color);
            }
        }
    }
    /// A line between two points, `thickness` pixels wide.
    pub fn line(&mut self, from: [f64; 2], to: [f64; 2], thickness: i64, color: Rgb) {
        // Lines that leave the image are cut to a bound, so that an extreme coordinate costs no time.
        let bound = |v: f64| v.clamp(-1e4, 1e4);
        let (from, to) = (from.map(bound), to.map(bound));
        let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
        let steps = dx.abs().max(dy.abs()).ceil().max(1.0);
        for i in 0..=steps as usize {
            let s = i as f64 / steps;
            let (x, y) = ((from[0] + s * dx).round() as i64, (from[1] + s * dy).round() as i64);
            self.rect(x - thickness / 2, y - thickness / 2, thickness, thickness, color);
        }
    }
    /// A line through points that covers what is below it by a share; where it meets itself it covers no more.
    pub fn polyline(&mut self, points: &[[f64; 2]], thickness: i64, color: Rgb, cover: f64) {
        let below = (cover < 1.0).then(|| self.clone());
        for pair in points.windows(2) {
            self.line(pair[0], pair[1], thickness, color);
        }
        let Some(below) = below else { return };
        for (pixel, under) in self.pixels.iter_mut().zip(&below.pixels) {
            if pixel != under {
                *pixel = mixed(*under, *pixel, cover);
            }
        }
    }
    /// A filled disc.
    pub fn disc(&mut self, center: [f64; 2], radius: f64, color: Rgb) {
        let r = radius.clamp(0.0, 1e4).ceil() as i64;
        let (cx, cy) = (center[0].round() as i64, center[1].round() as i64);
        for dy in -r..=r {
            for dx in -r..=r {
                if (dx * dx + dy * dy) as f64 <= radius * radius {
                    self.set(cx + dx, cy + dy, color);
                }
            }
        }
    }
    /// Text with its top left corner at (x, y), as high as that of a vector font of `size` pixels.
    pub fn text(&mut self, x: i64, y: i64, size: i64, color: Rgb, text: &str) {
        let letters = Letters::of(size);
        for (i, c) in text.chars().enumerate() {
            let left = x + i as i64 * letters.advance();
            for (row, inks) in letters.rows(c).enumerate() {
                for (column, ink) in inks.iter().enumerate() {
                    self.mix(left + column as i64, y + row as i64, color, f64::from(*ink) / 255.0);
                }
            }
        }
    }
    /// Covers a share of a pixel.
    fn mix(&mut self, x: i64, y: i64, color: Rgb, cover: f64) {
        if let (Ok(px), Ok(py)) = (usize::try_from(x), usize::try_from(y))
            && px < self.width
            && py < self.height
        {
            self.set(x, y, mixed(self.get(px, py), color, cover));
        }
    }
    /// Width of a text, and its height from its top to the line that it stands on, in pixels.
    pub fn text_size(size: i64, text: &str) -> [i64; 2] {
        let letters = Letters::of(size);
        [text.chars().count() as i64 * letters.advance(), letters.ascent()]
    }
    /// Copies another image with its top left corner at (x, y).
    pub fn paste(&mut self, x: i64, y: i64, image: &Canvas) {
        for py in 0..image.height {
            for px in 0..image.width {
                self.set(x + px as i64, y + py as i64, image.get(px, py));
            }
        }
    }
    /// Half the size, each pixel the mean of four: smooths edges.
    pub fn halved(&self) -> Self {
        let mut out = Self::new(self.width / 2, self.height / 2, [0; 3]);
        for y in 0..out.height {
            for x in 0..out.width {
                let mut color = [0; 3];
                for (k, channel) in color.iter_mut().enumerate() {
                    let at = |dx, dy| u16::from(self.get(2 * x + dx, 2 * y + dy)[k]);
                    *channel = ((at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1) + 2) / 4) as u8;
                }
                out.pixels[y * out.width + x] = color;
            }
        }
        out
    }
    /// Red, green and blue of all pixels, row by row.
    pub fn bytes(&self) -> &[u8] {
        self.pixels.as_flattened()
    }
    /// The image as a PNG file's bytes.
    ///
    /// # Errors
    /// If the encoder fails.
    pub fn png(&self) -> Result<Vec<u8>, png::EncodingError> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, self.width as u32, self.height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(self.pixels.as_flattened())?;
        writer.finish()?;
        Ok(bytes)
    }
    /// Writes the image as PNG.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<(), PlotError> {
        let bytes =
            self.png().map_err(|e| FileError { path: path.to_owned(), source: std::io::Error::other(e) })?;
        Ok(write_whole(path, &bytes)?)
    }
}

/// A color of which `cover`, 0 to 1, lies over another.
fn mixed(below: Rgb, above: Rgb, cover: f64) -> Rgb {
    let mix = |below: u8, above: u8| f64::from(below) + cover * (f64::from(above) - f64::from(below));
    core::array::from_fn(|k| mix(below[k], above[k]).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saved_image_decodes_to_its_pixels() {
        let mut image = Canvas::new(7, 5, [9, 9, 9]);
        image.set(6, 4, [1, 2, 3]);
        image.set(7, 0, [255; 3]);
        let png = image.png().expect("encodes");
        let mut reader = png::Decoder::new(std::io::Cursor::new(png)).read_info().expect("decodes");
        let mut bytes = vec![0; reader.output_buffer_size().expect("small")];
        let info = reader.next_frame(&mut bytes).expect("decodes");
        assert_eq!((info.width, info.height), (7, 5));
        assert_eq!(bytes, image.pixels.as_flattened());
        assert_eq!(bytes[bytes.len() - 3..], [1, 2, 3]);
    }

    #[test]
    fn drawing_outside_is_cut_off() {
        let mut image = Canvas::new(4, 4, [0; 3]);
        image.line([-50.0, 1.0], [f64::from(1 << 20), 1.0], 1, [255; 3]);
        image.disc([-1.0, -1.0], 1.0, [7; 3]);
        for x in 0..4 {
            assert_eq!((image.get(x, 1), image.get(x, 2)), ([255; 3], [0; 3]));
        }
    }

    #[test]
    fn text_stands_on_its_line_and_stays_within_its_width() {
        for size in [10, 14, 18, 22, 40] {
            let [width, height] = Canvas::text_size(size, "H1p");
            let mut image = Canvas::new(width as usize + 20, height as usize + 20, [0; 3]);
            image.text(0, 0, size, [255; 3], "H1p");
            let inked = |x: i64, y: i64| image.get(x as usize, y as usize)[0] > 127;
            // The tail of the p hangs below the line.
            let advance = width / 3;
            assert!((0..advance).any(|x| inked(x, height - 1)), "{size}");
            assert!((0..2 * advance).all(|x| !inked(x, height)), "{size}");
            assert!((2 * advance..width).any(|x| inked(x, height)), "{size}");
            assert!((0..height + 20).all(|y| !inked(width, y)), "{size}");
        }
        let mut image = Canvas::new(20, 20, [0; 3]);
        image.text(0, 0, 14, [255; 3], "\u{4e00}");
        let mut other = Canvas::new(20, 20, [0; 3]);
        other.text(0, 0, 14, [255; 3], "?");
        assert_eq!(image, other, "a character that the font lacks");
    }

    #[test]
    fn a_line_that_is_seen_through_covers_once_where_it_meets_itself() {
        let mut image = Canvas::new(5, 3, [200; 3]);
        image.polyline(&[[0.0, 1.0], [4.0, 1.0], [0.0, 1.0]], 1, [0; 3], 0.25);
        assert_eq!((image.get(2, 1), image.get(2, 0)), ([150; 3], [200; 3]));
        image.polyline(&[[2.0, 0.0], [2.0, 2.0]], 1, [0; 3], 1.0);
        assert_eq!(image.get(2, 1), [0; 3]);
    }

    #[test]
    fn halving_averages() {
        let mut image = Canvas::new(2, 2, [0; 3]);
        image.set(0, 0, [200, 100, 0]);
        assert_eq!(image.halved().get(0, 0), [50, 25, 0]);
    }
}
