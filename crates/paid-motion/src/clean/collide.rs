//! Parts of the robot near each other, with what it takes to move them apart.

use paid_lanes::Vec3;

use super::figure::{Figure, Frame};

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
                let points = nearest(*p, *q);
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

/// The nearest points of two segments: alternating projection onto each, which converges for segments as their distance is
/// convex; the ends are tried first.
fn nearest(a: [Vec3<f64>; 2], b: [Vec3<f64>; 2]) -> [Vec3<f64>; 2] {
    let (d, e, r) = (a[1] - a[0], b[1] - b[0], a[0] - b[0]);
    let (dd, ee) = (d.norm2().max(1e-12), e.norm2().max(1e-12));
    let (de, dr, er) = (d.dot(e), d.dot(r), e.dot(r));
    let lean = dd * ee - de * de;
    let mut s = if lean > 1e-12 { ((de * er - dr * ee) / lean).clamp(0.0, 1.0) } else { 0.5 };
    let mut t = ((er + s * de) / ee).clamp(0.0, 1.0);
    s = ((t * de - dr) / dd).clamp(0.0, 1.0);
    t = ((er + s * de) / ee).clamp(0.0, 1.0);
    [d.scale_add(s, a[0]), e.scale_add(t, b[0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_points_of_segments_are_found() {
        let x = [Vec3([0.0, 0.0, 0.0]), Vec3([1.0, 0.0, 0.0])];
        let over = [Vec3([0.5, -1.0, 2.0]), Vec3([0.5, 1.0, 2.0])];
        let [p, q] = nearest(x, over);
        assert!((p - Vec3([0.5, 0.0, 0.0])).norm() < 1e-12 && (q - Vec3([0.5, 0.0, 2.0])).norm() < 1e-12);
        let beyond = [Vec3([3.0, 0.0, 0.0]), Vec3([5.0, 1.0, 0.0])];
        let [p, q] = nearest(x, beyond);
        assert!((p.x() - 1.0).abs() < 1e-12 && (q - beyond[0]).norm() < 1e-12);
        let beside = [Vec3([0.2, 3.0, 0.0]), Vec3([0.9, 3.0, 0.0])];
        let [p, q] = nearest(x, beside);
        assert!(((p - q).norm() - 3.0).abs() < 1e-12);
    }
}
