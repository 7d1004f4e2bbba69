//! Parts of the robot in each other.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, Shape};

/// Two bodies in each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Overlap {
    /// The bodies.
    pub bodies: [usize; 2],
    /// Depth `[m]`.
    pub depth: f64,
}

/// Two ends and a radius, world `[m]`.
type Rod = (Vec3<f64>, Vec3<f64>, f64);

/// Pairs of bodies whose `collision` shapes may not meet: all but a body with its parent and the model's exclusions.
pub fn collision_pairs(model: &RobotModel) -> Vec<(usize, usize)> {
    let solid = |i: usize| model.bodies[i].geoms.iter().any(|g| g.class == "collision");
    let bodies: Vec<usize> = (0..model.bodies.len()).filter(|&i| solid(i)).collect();
    let mut pairs = Vec::new();
    for (k, &a) in bodies.iter().enumerate() {
        for &b in &bodies[k + 1..] {
            let family = model.bodies[b].parent == Some(a) || model.bodies[a].parent == Some(b);
            if !family && !model.contact_exclusions.contains(&(a, b)) {
                pairs.push((a, b));
            }
        }
    }
    pairs
}

/// The deepest overlap among `pairs`, if any; poses in model order. A box counts as the largest capsule along its longest side.
pub fn deepest_overlap(
    model: &RobotModel,
    pairs: &[(usize, usize)],
    pos: &[[f64; 3]],
    quat: &[[f64; 4]],
) -> Option<Overlap> {
    let place = |body: usize, p: [f64; 3]| Quat(quat[body]).rotate(Vec3(p)) + Vec3(pos[body]);
    let rods: Vec<Vec<Rod>> = model
        .bodies
        .iter()
        .enumerate()
        .map(|(i, body)| {
            let solid = body.geoms.iter().filter(|g| g.class == "collision");
            solid
                .map(|g| {
                    let (a, b, radius) = rod(&g.shape);
                    (place(i, a), place(i, b), radius)
                })
                .collect()
        })
        .collect();
    let mut worst: Option<Overlap> = None;
    for &(a, b) in pairs {
        for &(p, q, r) in &rods[a] {
            for &(u, v, s) in &rods[b] {
                let depth = r + s - segment_distance([p, q], [u, v]);
                if depth > worst.map_or(0.0, |w| w.depth) {
                    worst = Some(Overlap { bodies: [a, b], depth });
                }
            }
        }
    }
    worst
}

/// A shape as a segment with a radius.
pub(crate) fn rod(shape: &Shape) -> ([f64; 3], [f64; 3], f64) {
    match *shape {
        Shape::Sphere { center, radius } => (center, center, radius),
        Shape::Capsule { ends: [a, b], radius } => (a, b, radius),
        Shape::Box { center, half_size, quat } => {
            let longest = (0..3).max_by(|&i, &j| half_size[i].total_cmp(&half_size[j])).unwrap_or(0);
            let radius = half_size[(longest + 1) % 3].min(half_size[(longest + 2) % 3]);
            let mut along = [0.0; 3];
            along[longest] = half_size[longest] - radius;
            let arm = Quat(quat).rotate(Vec3(along));
            ((Vec3(center) - arm).0, (Vec3(center) + arm).0, radius)
        }
    }
}

/// Distance of two segments (closest points by clamping, Ericson, Real-Time Collision Detection, 5.1.9) `[m]`.
fn segment_distance([p, q]: [Vec3<f64>; 2], [u, v]: [Vec3<f64>; 2]) -> f64 {
    let (d, e, r) = (q - p, v - u, p - u);
    let (dd, ee, f) = (d.norm2(), e.norm2(), e.dot(r));
    let tiny = 1e-12;
    let (s, t) = if dd <= tiny && ee <= tiny {
        (0.0, 0.0)
    } else if dd <= tiny {
        (0.0, (f / ee).clamp(0.0, 1.0))
    } else {
        let c = d.dot(r);
        if ee <= tiny {
            ((-c / dd).clamp(0.0, 1.0), 0.0)
        } else {
            let b = d.dot(e);
            let lean = dd * ee - b * b;
            let s = if lean > tiny { ((b * f - c * ee) / lean).clamp(0.0, 1.0) } else { 0.0 };
            let t = (b * s + f) / ee;
            if t < 0.0 {
                ((-c / dd).clamp(0.0, 1.0), 0.0)
            } else if t > 1.0 {
                (((b - c) / dd).clamp(0.0, 1.0), 1.0)
            } else {
                (s, t)
            }
        }
    };
    (d.scale_add(s, p) - e.scale_add(t, u)).norm()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
        segment_distance(a.map(Vec3), b.map(Vec3))
    }

    #[test]
    fn segments_are_as_far_apart_as_their_nearest_points() {
        let x = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        assert_eq!(distance(x, [[0.5, -1.0, 2.0], [0.5, 1.0, 2.0]]), 2.0, "crossing");
        assert_eq!(distance(x, [[3.0, 0.0, 0.0], [5.0, 0.0, 0.0]]), 2.0, "end to end");
        assert_eq!(distance(x, [[0.2, 3.0, 0.0], [0.9, 3.0, 0.0]]), 3.0, "parallel");
        assert_eq!(distance(x, [[0.3, 0.0, 1.5]; 2]), 1.5, "a point");
        assert_eq!(distance([[0.0; 3]; 2], [[0.0, 4.0, 0.0]; 2]), 4.0, "two points");
    }
}
