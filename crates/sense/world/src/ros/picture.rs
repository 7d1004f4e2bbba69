//! `sensor_msgs/Image`: color and depth.

use paid_vision::{ColorImage, DepthImage};

use super::{Stamped, header, named};
use crate::cdr::{CdrReader, Wrong};
use crate::{SightError, recorder};

/// Most pixels a side that an image may have.
const MOST_PIXELS: usize = 8192;

/// What an image message holds.
struct Image<'a> {
    stamp_ns: u64,
    frame: String,
    size: [usize; 2],
    encoding: String,
    big_endian: bool,
    step: usize,
    data: &'a [u8],
}

/// Reads an image whose encoding is one of `wanted`, with this many bytes a pixel.
fn image<'a>(bytes: &'a [u8], wanted: &[&str], pixel: usize) -> Result<Image<'a>, Wrong> {
    let mut cdr = CdrReader::new(bytes)?;
    let (stamp_ns, frame) = header(&mut cdr)?;
    let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
    let encoding = cdr.string()?;
    let (big, step) = (cdr.u8()?, cdr.u32()? as usize);
    if !wanted.contains(&encoding.as_str()) {
        return Err((format!("encoding {}", wanted.join(" or ")), encoding));
    }
    if ![width, height].iter().all(|side| (1..=MOST_PIXELS).contains(side)) {
        return Err((format!("1 to {MOST_PIXELS} pixels a side"), format!("{width} x {height}")));
    }
    if step < pixel * width {
        let expected = format!("rows of at least {} bytes for {width} pixels", pixel * width);
        return Err((expected, format!("step {step}")));
    }
    let data = cdr.bytes()?;
    if data.len() != step * height {
        return Err((format!("{height} rows of {step} bytes"), format!("{} bytes", data.len())));
    }
    Ok(Image { stamp_ns, frame, size: [width, height], encoding, big_endian: big != 0, step, data })
}

/// A color image (`sensor_msgs/Image`, `rgb8` or `bgr8`).
///
/// # Errors
/// If the bytes are no such message, or encoding, size, step or stamp cannot be used.
pub fn read_color(bytes: &[u8]) -> Result<Stamped<ColorImage>, SightError> {
    let image = named("color image", image(bytes, &["rgb8", "bgr8"], 3))?;
    let [width, height] = image.size;
    let rows = image.data.chunks_exact(image.step).map(|row| &row[..3 * width]);
    let mut data = Vec::with_capacity(3 * width * height);
    rows.for_each(|row| data.extend_from_slice(row));
    if image.encoding == "bgr8" {
        data.chunks_exact_mut(3).for_each(|pixel| pixel.swap(0, 2));
    }
    let value = ColorImage::new(width, height, data)?;
    Ok(Stamped { stamp_ns: image.stamp_ns, frame: image.frame, value })
}

/// A depth image in millimeters (`sensor_msgs/Image`, `16UC1` or `mono16`).
///
/// # Errors
/// As [`read_color`].
pub fn read_depth(bytes: &[u8]) -> Result<Stamped<DepthImage>, SightError> {
    let image = named("depth image", image(bytes, &["16UC1", "mono16"], 2))?;
    let [width, height] = image.size;
    let mut data = Vec::with_capacity(width * height);
    for row in image.data.chunks_exact(image.step) {
        data.extend(row[..2 * width].chunks_exact(2).map(|pair| {
            let pair = [pair[0], pair[1]];
            if image.big_endian { u16::from_be_bytes(pair) } else { u16::from_le_bytes(pair) }
        }));
    }
    let value = DepthImage::new(width, height, data)?;
    Ok(Stamped { stamp_ns: image.stamp_ns, frame: image.frame, value })
}

/// A color image as a message, frame `camera_color_optical_frame`.
pub fn write_color(stamp_ns: u64, picture: &ColorImage) -> Vec<u8> {
    recorder::color_image(stamp_ns, picture).finish()
}

/// A depth image as a message, same frame.
pub fn write_depth(stamp_ns: u64, picture: &DepthImage) -> Vec<u8> {
    recorder::depth_image(stamp_ns, picture).finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A message by hand: stamp 5 s and 7 ns, frame "c", then height, width, encoding, byte order, step, data.
    fn by_hand([height, width]: [u32; 2], encoding: &str, big: u8, step: u32, data: &[u8]) -> Vec<u8> {
        let mut out = vec![0, 1, 0, 0];
        for word in [5_u32, 7, 2] {
            out.extend(word.to_le_bytes());
        }
        out.extend(b"c\0");
        let pad = |out: &mut Vec<u8>| {
            while !out.len().is_multiple_of(4) {
                out.push(0);
            }
        };
        pad(&mut out);
        for word in [height, width, encoding.len() as u32 + 1] {
            out.extend(word.to_le_bytes());
        }
        out.extend(encoding.as_bytes());
        out.extend([0, big]);
        pad(&mut out);
        out.extend(step.to_le_bytes());
        out.extend((data.len() as u32).to_le_bytes());
        out.extend(data);
        out
    }

    #[test]
    fn a_picture_made_by_hand_is_read_and_padding_of_its_rows_is_left_out() {
        // Two rows of one pixel, each followed by a byte that is none.
        let picture =
            read_color(&by_hand([2, 1], "rgb8", 0, 4, &[1, 2, 3, 99, 4, 5, 6, 99])).expect("an image");
        assert_eq!((picture.stamp_ns, picture.frame.as_str()), (5_000_000_007, "c"));
        assert_eq!(picture.value, ColorImage::new(1, 2, vec![1, 2, 3, 4, 5, 6]).expect("whole"));
        let picture = read_color(&by_hand([1, 1], "bgr8", 0, 3, &[1, 2, 3])).expect("an image");
        assert_eq!(picture.value.data, [3, 2, 1]);
        // 1500 mm is 0x05dc.
        let depth = read_depth(&by_hand([1, 2], "16UC1", 0, 4, &[0xdc, 0x05, 0, 0])).expect("depth");
        assert_eq!(depth.value.data, [1500, 0]);
        let depth = read_depth(&by_hand([1, 1], "16UC1", 1, 2, &[0x05, 0xdc])).expect("big-endian depth");
        assert_eq!(depth.value.data, [1500]);
    }

    #[test]
    fn each_wrong_picture_is_refused_with_what_was_expected_and_found() {
        let cases: [(Vec<u8>, &str); 6] = [
            (
                by_hand([1, 1], "yuv422", 0, 2, &[0; 2]),
                "color image: expected encoding rgb8 or bgr8, found yuv422",
            ),
            (by_hand([1, 2], "rgb8", 0, 3, &[0; 3]), "rows of at least 6 bytes for 2 pixels, found step 3"),
            (by_hand([2, 1], "rgb8", 0, 3, &[0; 3]), "2 rows of 3 bytes, found 3 bytes"),
            (by_hand([0, 1], "rgb8", 0, 3, &[]), "1 to 8192 pixels a side, found 1 x 0"),
            (vec![0, 0, 0, 0, 1], "expected little-endian CDR"),
            (by_hand([1, 1], "rgb8", 0, 3, &[0; 3])[..20].to_vec(), "found the end at 16"),
        ];
        for (bytes, expected) in cases {
            let error = read_color(&bytes).expect_err(expected).to_string();
            assert!(error.contains(expected), "{error}");
        }
        let error = read_depth(&by_hand([1, 1], "32FC1", 0, 4, &[0; 4])).expect_err("meters").to_string();
        assert_eq!(error, "depth image: expected encoding 16UC1 or mono16, found 32FC1");
        let mut unset = by_hand([1, 1], "rgb8", 0, 3, &[0; 3]);
        unset[4..12].fill(0);
        assert!(read_color(&unset).expect_err("no stamp").to_string().contains("a stamp, found 0 ns"));
    }
}
