//! `sensor_msgs/CameraInfo`.

use paid_vision::Intrinsics;

use super::{Stamped, header, named};
use crate::cdr::{CdrReader, Wrong};
use crate::{SightError, recorder};

/// A lens is taken for one without distortion if no coefficient is larger: at a corner of a D435i's color image half of this is one pixel.
const MOST_DISTORTION: f64 = 0.01;

/// A camera (`sensor_msgs/CameraInfo`): whole image, no distortion.
///
/// # Errors
/// If the bytes are no such message, or the camera is not one that perception can use.
pub fn read_camera_info(bytes: &[u8]) -> Result<Stamped<Intrinsics>, SightError> {
    let stamped = named("camera info", camera_info(bytes))?;
    stamped.value.check()?;
    Ok(stamped)
}

fn camera_info(bytes: &[u8]) -> Result<Stamped<Intrinsics>, Wrong> {
    let mut cdr = CdrReader::new(bytes)?;
    let (stamp_ns, frame) = header(&mut cdr)?;
    let (height, width) = (cdr.u32()? as usize, cdr.u32()? as usize);
    let model = cdr.string()?;
    let distortion = cdr.f64_list()?;
    let [fx, skew, cx, _, fy, cy, ..] = cdr.f64s::<9>()?;
    cdr.f64s::<9>()?;
    cdr.f64s::<12>()?;
    let (binning, corner, part) =
        ([cdr.u32()?, cdr.u32()?], [cdr.u32()?, cdr.u32()?], [cdr.u32()?, cdr.u32()?]);
    if distortion.iter().any(|d| d.is_nan() || d.abs() > MOST_DISTORTION) {
        let expected = format!("no distortion, coefficients within {MOST_DISTORTION}");
        return Err((expected, format!("{model} {distortion:?}")));
    }
    let whole = corner == [0, 0] && (part == [0, 0] || part == [height as u32, width as u32]);
    if binning.iter().any(|b| *b > 1) || !whole || skew != 0.0 {
        let found = format!("binning {binning:?}, region {corner:?} {part:?}, skew {skew}");
        return Err(("a whole image without binning and skew".to_owned(), found));
    }
    let value = Intrinsics { width, height, focal: [fx, fy], center: [cx, cy] };
    Ok(Stamped { stamp_ns, frame, value })
}

/// A camera as a message, same frame.
pub fn write_camera_info(stamp_ns: u64, camera: &Intrinsics) -> Vec<u8> {
    recorder::camera(stamp_ns, camera).finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_camera_with_distortion_or_without_a_focal_length_is_refused() {
        let camera = Intrinsics::g1_color();
        let bytes = write_camera_info(9_000_000_001, &camera);
        // Header 4 + 8 + 4 + 27 + 1, two sides, "plumb_bob" with its length, then five coefficients.
        let at = bytes.windows(8).position(|w| w == [0; 8]).expect("a coefficient");
        let first = (at - 4).next_multiple_of(8) + 4;
        let mut bent = bytes.clone();
        bent[first..first + 8].copy_from_slice(&0.2_f64.to_le_bytes());
        let error = read_camera_info(&bent).expect_err("a bent lens").to_string();
        assert!(error.contains("no distortion") && error.contains("0.2"), "{error}");
        let unset = Intrinsics { focal: [0.0; 2], ..camera };
        let error = read_camera_info(&write_camera_info(9_000_000_001, &unset)).expect_err("never filled");
        assert!(error.to_string().contains("focal"), "{error}");
    }
}
