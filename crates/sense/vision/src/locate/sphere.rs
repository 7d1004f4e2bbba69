//! The ball's center in the camera's frame.

use paid_lanes::stats::median;

use super::depths::{ByDepth, FEWEST, by_depth};
use crate::detect::Detection;
use crate::{DepthImage, Intrinsics, PixelBox};

/// What a distance was taken from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// Depth under box or mask.
    Depth,
    /// Where the ray meets the floor, for a ball that lies on it.
    Floor,
    /// The size of the box and the known radius.
    Size,
}

/// A ball's center.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fix {
    /// Camera frame `[m]`.
    pub position: [f64; 3],
    /// What its distance was taken from.
    pub source: Source,
    /// What a pixel's error of the box, or the spread of the depths, makes of it: standard deviation along the ray `[m]`.
    pub deviation_m: f64,
}

/// A flat floor in the camera's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floor {
    /// Its upward normal, a unit vector.
    pub up: [f64; 3],
    /// Height of the camera above it `[m]`.
    pub height_m: f64,
}

/// A box that touches the image's edge this closely is cut off there `[px]`.
const EDGE_PX: f64 = 1.5;

/// The outline of a ball as angles.
pub(super) struct Outline {
    /// Unit vector to the middle.
    pub(super) toward: [f64; 3],
    /// Half its opening angle `[rad]`; `None` if the image's edge cuts it in both directions.
    pub(super) half_angle: Option<f64>,
    /// Ellipse in the image: middle and half axes `[px]`.
    pub(super) ellipse: [[f64; 2]; 2],
}

/// Where a ball of `radius_m` is that was detected in an image of these `intrinsics`.
///
/// With depth: every pixel inside the outline (or the mask) gives a distance of the center, because its ray meets a sphere of known radius:
/// `D = rho cos(theta) + sqrt(R^2 - rho^2 sin(theta)^2)`, with the range `rho` of the pixel and its angle `theta` from the middle. The
/// median is taken of those that agree with most others, weighted by how well they fit to the outline's size. Without enough pixels with a
/// depth the ray's meeting with the floor, if it fits to the size; else the size.
///
/// `None` if the box is empty, outside the image, or does not determine the distance, and if there are depths that no ball of this size
/// gives: a spot on the floor, a foot with floor around it, the side of a box.
pub fn locate(
    detection: &Detection,
    depth: Option<&DepthImage>,
    intrinsics: &Intrinsics,
    radius_m: f64,
    floor: Option<&Floor>,
) -> Option<Fix> {
    let outline = Outline::of(detection, intrinsics, radius_m, depth)?;
    let by_size = outline.half_angle.map(|half| radius_m / half.sin());
    let placed = |distance: f64, source: Source, deviation_m: f64| {
        (distance.is_finite() && distance > radius_m && distance < 100.0).then(|| Fix {
            position: outline.toward.map(|v| v * distance),
            source,
            deviation_m,
        })
    };
    // A pixel's error of the size, as a share of it.
    let pixels = 2.0 * outline.ellipse[1][0].min(outline.ellipse[1][1]);
    let share = 1.5 / pixels.max(1.5);
    if let Some(depth) = depth {
        match by_depth(detection, depth, intrinsics, radius_m, &outline, by_size) {
            ByDepth::Known(distance, deviation) => return placed(distance, Source::Depth, deviation),
            ByDepth::Contradiction => return None,
            ByDepth::Unknown => {}
        }
    }
    let by_floor = floor.and_then(|floor| {
        let down = -dot(outline.toward, floor.up);
        let distance = (floor.height_m - radius_m) / down;
        // A ray that grazes the floor gives no distance.
        (down > 0.05 && distance > 0.0).then(|| {
            let pixel = 1.0 / intrinsics.focal[1];
            (distance, distance * pixel / down)
        })
    });
    if let Some((distance, deviation)) = by_floor
        && by_size.is_none_or(|size| (distance / size - 1.0).abs() < 0.15_f64.max(2.0 * share))
    {
        return placed(distance, Source::Floor, deviation);
    }
    by_size.and_then(|size| placed(size, Source::Size, size * share / 1.5))
}

impl Outline {
    /// From the box; sides that the image's edge cuts are placed from the others and a depth.
    fn of(
        detection: &Detection,
        intrinsics: &Intrinsics,
        radius: f64,
        depth: Option<&DepthImage>,
    ) -> Option<Self> {
        let mut found = detection.outline;
        let seen = found.clipped(intrinsics.width, intrinsics.height);
        if !found.min.iter().chain(&found.max).all(|v| v.is_finite()) || seen.area() < 1.0 {
            return None;
        }
        let picture = [intrinsics.width as f64, intrinsics.height as f64];
        let cut = |k: usize| {
            let (low, high) = (found.min[k] <= EDGE_PX, found.max[k] >= picture[k] - EDGE_PX);
            if detection.whole { [false, false] } else { [low, high] }
        };
        let cuts = [cut(0), cut(1)];
        let is_cut = cuts.map(|c| c[0] || c[1]);
        if is_cut[0] || is_cut[1] {
            let size = match is_cut {
                [true, false] => found.size()[1] * intrinsics.focal[0] / intrinsics.focal[1],
                [false, true] => found.size()[0] * intrinsics.focal[1] / intrinsics.focal[0],
                _ => {
                    // Cut both ways: as large as its depth implies.
                    let z = middle_depth(&seen, depth?)? + radius;
                    2.0 * radius / z * intrinsics.focal[0]
                }
            };
            for k in 0..2 {
                match cuts[k] {
                    [true, false] => found.min[k] = found.max[k] - size.max(found.size()[k]),
                    [false, true] => found.max[k] = found.min[k] + size.max(found.size()[k]),
                    _ => {}
                }
            }
        }
        // The middle of a sphere's outline lies between its tangents in angle, not in pixels.
        let angle = |k: usize, v: f64| ((v - intrinsics.center[k]) / intrinsics.focal[k]).atan();
        let sides = [0, 1].map(|k| [angle(k, found.min[k]), angle(k, found.max[k])]);
        let middle = sides.map(|[a, b]| 0.5 * (a + b));
        let toward = unit([middle[0].tan(), middle[1].tan(), 1.0]);
        // In the plane of the axis and an image direction, the sphere opens by asin(R / distance in that plane).
        let half = [0, 1].map(|k| {
            let across = middle[1 - k].tan();
            let in_plane = 1.0 / (1.0 + across * across * middle[k].cos().powi(2)).sqrt();
            ((0.5 * (sides[k][1] - sides[k][0])).sin() * in_plane).asin()
        });
        let half_angle = match is_cut {
            [true, true] => None,
            [true, false] => Some(half[1]),
            [false, true] => Some(half[0]),
            [false, false] => Some(0.5 * (half[0] + half[1])),
        };
        let size = found.size();
        Some(Self {
            toward,
            half_angle: half_angle.filter(|a| a.is_finite() && *a > 1e-4),
            ellipse: [found.middle(), [0.5 * size[0], 0.5 * size[1]]],
        })
    }
}

/// The median depth of the middle part of a box `[m]`.
fn middle_depth(seen: &PixelBox, depth: &DepthImage) -> Option<f64> {
    let (middle, size) = (seen.middle(), seen.size());
    let range = |k: usize| {
        (middle[k] - 0.25 * size[k]).max(0.0) as usize..=(middle[k] + 0.25 * size[k]).max(0.0) as usize
    };
    let mut depths: Vec<f64> =
        range(1).flat_map(|y| range(0).filter_map(move |x| depth.depth_m(x, y))).collect();
    (depths.len() >= FEWEST).then(|| median(&mut depths)).flatten()
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let norm = dot(a, a).sqrt();
    a.map(|v| v / norm)
}
