//! Parts of the robot near each other, and how to move them apart.

use paid_lanes::Vec3;

use super::figure::{Figure, Frame};
use crate::check::nearest_points;

/// Two bodies that are near each other.
pub(super) struct Near {
    pub bodies: [usize; 2],
    /// Distance of the surfaces; negative: how deep `[m]`.
    pub gap: f64,
    /// Nearest points of the two segments, world.
    pub points: [Vec3<f64>; 2],
    /// From the second point to the first.
    pub normal: Vec3<f64>,
}

/// Calls `see` for every pair of shapes with less than `within` between them.
pub(super) fn near(figure: &Figure<'_>, frame: &Frame, within: f64, mut see: impl FnMut(&Near)) {
    let place = |body: usize, p: Vec3<f64>| frame.pos[body] + frame.quat[body].rotate(p);
    let rods: Vec<Vec<([Vec3<f64>; 2], f64)>> = figure
        .rods
        .iter()
        .enumerate()
        .map(|(i, rods)| rods.iter().map(|r| (r.ends.map(|p| place(i, p)), r.radius)).collect())
        .collect();
    for &(a, b) in &figure.pairs {
        for (p, r) in &rods[a] {
            for (q, s) in &rods[b] {
                let reach = r + s + within;
                // Cheap test: balls around the segments.
                let (mid, half) = (ball(p), ball(q));
                if (mid.0 - half.0).norm() > reach + mid.1 + half.1 {
                    continue;
                }
                let points = nearest_points(*p, *q);
                let way = points[0] - points[1];
                let distance = way.norm();
                if distance < reach && distance > 1e-9 {
                    let normal = way.scale(1.0 / distance);
                    see(&Near { bodies: [a, b], gap: distance - r - s, points, normal });
                }
            }
        }
    }
}

fn ball(ends: &[Vec3<f64>; 2]) -> (Vec3<f64>, f64) {
    ((ends[0] + ends[1]).scale(0.5), 0.5 * (ends[1] - ends[0]).norm())
}
