//! Distance of a ball's center from the depths under its outline.

use paid_lanes::stats::median;

use super::sphere::{Outline, dot};
use crate::detect::Detection;
use crate::{DepthImage, Intrinsics};

/// Fewest pixels with a depth that a place is taken from.
pub(super) const FEWEST: usize = 8;

/// Distance of the center of a ball of this `radius` `[m]`, from the pixels inside its outline.
pub(super) fn by_depth(
    detection: &Detection,
    depth: &DepthImage,
    intrinsics: &Intrinsics,
    radius: f64,
    outline: &Outline,
    by_size: Option<f64>,
) -> ByDepth {
    if [depth.width, depth.height] != [intrinsics.width, intrinsics.height] {
        return ByDepth::Unknown;
    }
    let part = detection.outline.clipped(intrinsics.width, intrinsics.height);
    let [middle, half] = outline.ellipse;
    let (mut distances, mut points) = (Vec::new(), Vec::new());
    let last = [intrinsics.width - 1, intrinsics.height - 1];
    for y in part.min[1] as usize..=(part.max[1] as usize).min(last[1]) {
        for x in part.min[0] as usize..=(part.max[0] as usize).min(last[0]) {
            let pixel = [x as f64 + 0.5, y as f64 + 0.5];
            let inside = match &detection.mask {
                Some(mask) => mask.holds(x, y),
                None => {
                    let d = [0, 1].map(|k| (pixel[k] - middle[k]) / half[k].max(0.5));
                    d[0] * d[0] + d[1] * d[1] < 0.85 * 0.85
                }
            };
            let Some(z) = (if inside { depth.depth_m(x, y) } else { None }) else { continue };
            let point = intrinsics.ray(pixel).map(|v| v * z);
            points.push(point);
            let along = dot(point, outline.toward);
            let across2 = dot(point, point) - along * along;
            let rest = radius * radius - across2;
            if rest < 0.0 {
                continue;
            }
            distances.push(along + rest.sqrt());
        }
    }
    if distances.len() < FEWEST {
        return ByDepth::Unknown;
    }
    distances.sort_by(f64::total_cmp);
    let Some(first) = most_alike(&distances, by_size) else { return ByDepth::Contradiction };
    let mut near: Vec<f64> = distances.iter().copied().filter(|d| (d / first - 1.0).abs() < WINDOW).collect();
    let middle = median(&mut near).unwrap_or_default();
    let mut off: Vec<f64> = near.iter().map(|d| (d - middle).abs()).collect();
    // The deviation of a normal distribution is 1.48 times the median of the distances from its middle.
    let spread = 1.48 * median(&mut off).unwrap_or_default();
    near.retain(|d| (d - middle).abs() <= (3.0 * spread).max(0.01));
    let count = near.len() as f64;
    let distance = median(&mut near).unwrap_or_default();
    if spread > MOST_SPREAD * (1.0 + distance * distance)
        || seen_through(&points, outline.toward.map(|v| v * distance), radius) > MOST_SEEN_THROUGH
    {
        return ByDepth::Contradiction;
    }
    // Neighbors err together: of 16 pixels one counts.
    ByDepth::Known(distance, 1.25 * spread.max(0.002) / (count / 16.0).max(1.0).sqrt())
}

/// The share of the points `[m]`, in the camera's frame, that lie behind the front of a ball at `center`, and so are seen through it.
fn seen_through(points: &[[f64; 3]], center: [f64; 3], radius: f64) -> f64 {
    let through = |point: &&[f64; 3]| {
        let range = dot(**point, **point).sqrt();
        let along = dot(**point, center) / range;
        // Half the chord that the ray has within the ball; 0 for a ray that misses it, which is nearest to the center at `along`.
        let chord = (radius * radius - (dot(center, center) - along * along)).max(0.0).sqrt();
        range > along - chord + (DEEP_RADII * radius).max(DEPTH_ERROR * range * range)
    };
    points.iter().filter(through).count() as f64 / points.len().max(1) as f64
}

/// The distance from depth.
pub(super) enum ByDepth {
    /// Distance of the center and the standard deviation of that median `[m]`.
    Known(f64, f64),
    /// Too few pixels have a depth.
    Unknown,
    /// There are depths, and no ball of this size gives them.
    Contradiction,
}

/// A point is behind a ball's front if it is deeper by this share of the radius: boxes err by a pixel or two, and the front curves away ...
const DEEP_RADII: f64 = 0.35;
/// ... and by this much of the square of its range `[1/m]`: three deviations of a D435i, 3.6 mm at 1 m.
const DEPTH_ERROR: f64 = 0.011;
/// No ball is transparent. A larger share of points behind its front is the floor around a foot or a small box. Less happens at the rim.
const MOST_SEEN_THROUGH: f64 = 0.15;
/// The depths of a ball agree on its center up to this times `1 + distance^2` `[m]`, distance in meters: the camera's 3.6 mm at 1 m and what
/// a box that is wrong by a pixel makes of the ball's curvature. Those of a flat side or a long foot do not.
const MOST_SPREAD: f64 = 0.005;
/// Depths within this share of a distance are alike.
const WINDOW: f64 = 0.04;
/// A box is wrong by more than this factor only if it is no ball's.
const WRONG_SIZE: f64 = 1.4;

/// The distance that most of the sorted `distances` are near, each counted by how well it fits to the size: a leg before the ball is nearer, the
/// floor behind it farther. `None` if none fits.
fn most_alike(distances: &[f64], by_size: Option<f64>) -> Option<f64> {
    let fit = |distance: f64| {
        by_size.map_or(1.0, |size| {
            let off = (distance / size).ln();
            if off.abs() > WRONG_SIZE.ln() { 0.0 } else { (-0.5 * (off / 0.12).powi(2)).exp() }
        })
    };
    let (mut best, mut found) = (0.0, None);
    let (mut low, mut high) = (0, 0);
    for (k, &distance) in distances.iter().enumerate() {
        while distances[low] < distance * (1.0 - WINDOW) {
            low += 1;
        }
        while high < distances.len() && distances[high] <= distance * (1.0 + WINDOW) {
            high += 1;
        }
        let weight = (high - low) as f64 * fit(distance);
        if weight > best && high - low >= FEWEST.min(distances.len()) {
            (best, found) = (weight, Some(k));
        }
    }
    found.map(|k| distances[k])
}
