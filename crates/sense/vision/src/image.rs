//! Images as plain numbers.

use crate::VisionError;

/// A color image, red, green and blue, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ColorImage {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// `3 width height` bytes (sRGB).
    pub data: Vec<u8>,
}

impl ColorImage {
    /// An image from its bytes.
    ///
    /// # Errors
    /// If their number is not `3 width height`, or the image is empty.
    pub fn new(width: usize, height: usize, data: Vec<u8>) -> Result<Self, VisionError> {
        let expected = width.checked_mul(height).and_then(|n| n.checked_mul(3)).unwrap_or(usize::MAX);
        if expected == 0 || data.len() != expected {
            return Err(VisionError::value(
                format!("color image of {width} x {height}"),
                format!("{expected} bytes"),
                data.len().to_string(),
            ));
        }
        Ok(Self { width, height, data })
    }

    /// An image of one color.
    pub fn filled(width: usize, height: usize, color: [u8; 3]) -> Self {
        Self { width, height, data: color.repeat(width * height) }
    }

    /// The color of a pixel inside the image.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> [u8; 3] {
        let at = 3 * (y * self.width + x);
        [self.data[at], self.data[at + 1], self.data[at + 2]]
    }

    /// Sets a pixel; outside the image nothing happens.
    pub fn set(&mut self, x: i64, y: i64, color: [u8; 3]) {
        if let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y))
            && x < self.width
            && y < self.height
        {
            let at = 3 * (y * self.width + x);
            self.data[at..at + 3].copy_from_slice(&color);
        }
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
        writer.write_image_data(&self.data)?;
        writer.finish()?;
        Ok(bytes)
    }
}

/// A depth image aligned to the color image, row by row from the top.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DepthImage {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// Depth along the optical axis `[mm]`, `width height` of them; 0 where it is not known.
    pub data: Vec<u16>,
}

impl DepthImage {
    /// An image from its numbers.
    ///
    /// # Errors
    /// If there are not `width height` of them, or the image is empty.
    pub fn new(width: usize, height: usize, data: Vec<u16>) -> Result<Self, VisionError> {
        let expected = width.saturating_mul(height);
        if expected == 0 || data.len() != expected {
            return Err(VisionError::value(
                format!("depth image of {width} x {height}"),
                format!("{expected} numbers"),
                data.len().to_string(),
            ));
        }
        Ok(Self { width, height, data })
    }

    /// Depth at a pixel `[m]`; `None` where it is not known or outside the image.
    #[inline]
    pub fn depth_m(&self, x: usize, y: usize) -> Option<f64> {
        if x >= self.width || y >= self.height {
            return None;
        }
        let mm = self.data[y * self.width + x];
        (mm > 0).then(|| f64::from(mm) * 1e-3)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_torn_picture_is_refused() {
        let error = ColorImage::new(4, 2, vec![0; 23]).expect_err("a byte is missing").to_string();
        assert!(error.contains("24 bytes") && error.contains("23"), "{error}");
        assert!(ColorImage::new(0, 0, Vec::new()).is_err());
        assert!(DepthImage::new(2, 2, vec![0; 3]).is_err());
        let depth = DepthImage::new(2, 1, vec![0, 1500]).expect("whole");
        assert_eq!((depth.depth_m(0, 0), depth.depth_m(1, 0), depth.depth_m(2, 0)), (None, Some(1.5), None));
    }
}
