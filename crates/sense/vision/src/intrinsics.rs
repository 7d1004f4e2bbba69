//! An image's geometry: pixels and rays.

use paid_track::CameraPreset;
use serde::{Deserialize, Serialize};

use crate::VisionError;

/// A pinhole camera without distortion. Pixel (0, 0) is the top left one and its middle lies at (0.5, 0.5).
///
/// Camera frame: x to the right, y down, z along the optical axis (ROS' optical frame).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intrinsics {
    /// Pixels from left to right.
    pub width: usize,
    /// Pixels from top to bottom.
    pub height: usize,
    /// Focal lengths, across and down `[px]`.
    pub focal: [f64; 2],
    /// Where the optical axis meets the image `[px]`.
    pub center: [f64; 2],
}

impl Intrinsics {
    /// A centered image of this size that opens by `across_deg` from left to right and `upright_deg` from top to bottom (full
    /// angles).
    pub fn from_angles(width: usize, height: usize, across_deg: f64, upright_deg: f64) -> Self {
        let (w, h) = (width as f64, height as f64);
        let focal = |size: f64, degrees: f64| 0.5 * size / (0.5 * degrees.to_radians()).tan();
        Self {
            width,
            height,
            focal: [focal(w, across_deg), focal(h, upright_deg)],
            center: [0.5 * w, 0.5 * h],
        }
    }

    /// The image of a camera of the robot.
    pub fn of(camera: &CameraPreset, width: usize, height: usize) -> Self {
        Self::from_angles(width, height, camera.across_deg, camera.upright_deg)
    }

    /// The color image of the G1's depth camera, 424 x 240 pixels, 69 x 42 degrees.
    pub fn g1_color() -> Self {
        Self::of(&CameraPreset::color(), 424, 240)
    }

    /// Refuses a camera that no image can have, such as one whose `CameraInfo` was never filled.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), VisionError> {
        let wrong = |what: &str, expected: &str, found: String| {
            Err(VisionError::Value { what: what.to_owned(), expected: expected.to_owned(), found })
        };
        if !(1..=8192).contains(&self.width) || !(1..=8192).contains(&self.height) {
            let found = format!("{} x {}", self.width, self.height);
            return wrong("intrinsics: size", "1 to 8192 pixels a side", found);
        }
        let size = [self.width as f64, self.height as f64];
        for k in 0..2 {
            if !(0.05 * size[k]..=50.0 * size[k]).contains(&self.focal[k]) {
                let expected = "a focal length of 0.05 to 50 image sizes";
                return wrong("intrinsics: focal", expected, format!("{:?} px", self.focal));
            }
            if !(-size[k]..=2.0 * size[k]).contains(&self.center[k]) {
                return wrong(
                    "intrinsics: center",
                    "a point near the image",
                    format!("{:?} px", self.center),
                );
            }
        }
        Ok(())
    }

    /// The ray through a point of the image `[px]`, camera frame, of depth 1.
    #[inline]
    pub fn ray(&self, pixel: [f64; 2]) -> [f64; 3] {
        [(pixel[0] - self.center[0]) / self.focal[0], (pixel[1] - self.center[1]) / self.focal[1], 1.0]
    }

    /// Where a point of the camera frame `[m]` is in the image `[px]`; `None` behind the camera.
    #[inline]
    pub fn project(&self, point: [f64; 3]) -> Option<[f64; 2]> {
        (point[2] > 1e-6)
            .then(|| [0, 1].map(|k| (point[k] / point[2]).mul_add(self.focal[k], self.center[k])))
    }

    /// The smallest box around the outline of a sphere (center in the camera frame and radius `[m]`); `None` if the camera is inside
    /// or the sphere reaches behind the image plane.
    pub fn sphere_box(&self, center: [f64; 3], radius: f64) -> Option<PixelBox> {
        let mut sides = [[0.0; 2]; 2];
        for k in 0..2 {
            // The tangents in the plane of the axis and this image direction.
            let (x, z) = (center[k], center[2]);
            let denominator = z * z - radius * radius;
            if z <= radius || denominator <= 1e-9 {
                return None;
            }
            let root = radius * (x * x + denominator).sqrt();
            sides[k] = [-1.0, 1.0]
                .map(|sign| ((x * z + sign * root) / denominator).mul_add(self.focal[k], self.center[k]));
        }
        Some(PixelBox { min: [sides[0][0], sides[1][0]], max: [sides[0][1], sides[1][1]] })
    }

    /// A part of the image: `left` and `top` may lie outside.
    pub fn window(&self, left: f64, top: f64, width: usize, height: usize) -> Self {
        Self { width, height, center: [self.center[0] - left, self.center[1] - top], ..*self }
    }

    /// The same view with other pixels.
    pub fn resized(&self, width: usize, height: usize) -> Self {
        let scale = [width as f64 / self.width as f64, height as f64 / self.height as f64];
        let scaled = |v: [f64; 2]| [v[0] * scale[0], v[1] * scale[1]];
        Self { width, height, focal: scaled(self.focal), center: scaled(self.center) }
    }
}

/// A rectangle in an image `[px]`; its sides may lie outside the image and between pixels.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PixelBox {
    /// Left and top side.
    pub min: [f64; 2],
    /// Right and bottom side.
    pub max: [f64; 2],
}

impl PixelBox {
    /// From middle and size `[px]`.
    pub fn around(middle: [f64; 2], size: [f64; 2]) -> Self {
        Self {
            min: [0, 1].map(|k| middle[k] - 0.5 * size[k]),
            max: [0, 1].map(|k| middle[k] + 0.5 * size[k]),
        }
    }

    /// The middle `[px]`.
    pub fn middle(&self) -> [f64; 2] {
        [0, 1].map(|k| 0.5 * (self.min[k] + self.max[k]))
    }

    /// Width and height `[px]`.
    pub fn size(&self) -> [f64; 2] {
        [0, 1].map(|k| self.max[k] - self.min[k])
    }

    /// Area `[px^2]`; 0 if a side is turned.
    pub fn area(&self) -> f64 {
        let [w, h] = self.size();
        w.max(0.0) * h.max(0.0)
    }

    /// The common part.
    pub fn overlap(&self, other: &Self) -> Self {
        Self {
            min: [0, 1].map(|k| self.min[k].max(other.min[k])),
            max: [0, 1].map(|k| self.max[k].min(other.max[k])),
        }
    }

    /// Area of the common part over that of the union, 0 to 1.
    pub fn iou(&self, other: &Self) -> f64 {
        let common = self.overlap(other).area();
        let union = self.area() + other.area() - common;
        if union > 0.0 { common / union } else { 0.0 }
    }

    /// The part inside an image.
    pub fn clipped(&self, width: usize, height: usize) -> Self {
        self.overlap(&Self { min: [0.0; 2], max: [width as f64, height as f64] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_returns_along_its_ray() {
        let camera = Intrinsics::g1_color();
        // 424 px over 69 degrees: 212 / tan(34.5 deg).
        assert!((camera.focal[0] - 308.46).abs() < 0.05, "{camera:?}");
        let pixel = camera.project([0.3, -0.2, 1.5]).expect("in front");
        let ray = camera.ray(pixel);
        assert!((ray[0] - 0.2).abs() < 1e-12 && (ray[1] + 0.2 / 1.5).abs() < 1e-12);
        assert_eq!(camera.project([0.0, 0.0, -1.0]), None);
    }

    #[test]
    fn the_box_of_a_sphere_on_the_axis_is_its_tangent_cone() {
        let camera = Intrinsics { width: 200, height: 100, focal: [100.0; 2], center: [100.0, 50.0] };
        let found = camera.sphere_box([0.0, 0.0, 2.0], 1.0).expect("in front");
        // tan(asin(1 / 2)) = 0.57735
        for (side, expected) in [(found.min[0], 42.265), (found.max[0], 157.735), (found.max[1], 107.735)] {
            assert!((side - expected).abs() < 1e-3, "{found:?}");
        }
        assert_eq!(camera.sphere_box([0.0, 0.0, 0.5], 1.0), None);
    }

    #[test]
    fn boxes_overlap_by_area() {
        let a = PixelBox { min: [0.0, 0.0], max: [4.0, 4.0] };
        let b = PixelBox { min: [2.0, 2.0], max: [6.0, 6.0] };
        assert!((a.iou(&b) - 4.0 / 28.0).abs() < 1e-12);
        assert_eq!(a.iou(&PixelBox { min: [9.0, 9.0], max: [10.0, 10.0] }), 0.0);
    }

    #[test]
    fn wrong_intrinsics_are_refused_with_what_was_found() {
        let empty = Intrinsics { width: 640, height: 480, focal: [0.0; 2], center: [0.0; 2] };
        let error = empty.check().expect_err("a CameraInfo that was never filled").to_string();
        assert!(error.contains("focal") && error.contains("[0.0, 0.0]"), "{error}");
        assert!(Intrinsics::g1_color().check().is_ok());
    }
}
