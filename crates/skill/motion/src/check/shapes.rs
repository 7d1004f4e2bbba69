//! Parts of the robot in each other.

use paid_lanes::{Quat, Vec3};
use paid_robot::{RobotModel, Shape};

/// How deep two bodies are in each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Overlap {
    /// The bodies.
    pub bodies: [usize; 2],
    /// Depth `[m]`, negative where they are apart.
    pub depth: f64,
}

/// Two ends and a radius, world `[m]`.
pub(crate) type Rod = (Vec3<f64>, Vec3<f64>, f64);

/// Pairs of bodies whose `collision` shapes may not meet: all but a body with its parent and the model's exclusions.
pub fn collision_pairs(model: &RobotModel) -> Vec<(usize, usize)> {
    let bodies: Vec<usize> = (0..model.bodies.len()).filter(|&i| is_solid(model, i)).collect();
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

/// Whether a body has a `collision` shape.
fn is_solid(model: &RobotModel, body: usize) -> bool {
    model.bodies[body].geoms.iter().any(|g| g.class == "collision")
}

/// The end of the leg of this foot: the foot and the next body with a `collision` shape above it, a humanoid's shin.
pub fn lower_leg(model: &RobotModel, foot: usize) -> Vec<usize> {
    let above = std::iter::successors(Some(foot), |&i| model.bodies[i].parent);
    above.filter(|&i| is_solid(model, i)).take(2).collect()
}

/// Pairs of one lower leg's bodies and the other's.
pub(crate) fn leg_pairs(model: &RobotModel, feet: [usize; 2]) -> Vec<(usize, usize)> {
    let [left, right] = feet.map(|foot| lower_leg(model, foot));
    left.iter().flat_map(|&a| right.iter().map(move |&b| (a, b))).collect()
}

/// Every body's `collision` shapes in the world; poses in model order.
pub(crate) fn rods(model: &RobotModel, pos: &[[f64; 3]], quat: &[[f64; 4]]) -> Vec<Vec<Rod>> {
    let place = |body: usize, p: [f64; 3]| Quat(quat[body]).rotate(Vec3(p)) + Vec3(pos[body]);
    model
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
        .collect()
}

/// The deepest overlap among `pairs`, or the nearest two where none overlap. Distances that are no numbers do not count.
pub(crate) fn deepest(rods: &[Vec<Rod>], pairs: &[(usize, usize)]) -> Option<Overlap> {
    let mut worst: Option<Overlap> = None;
    for &(a, b) in pairs {
        for &(p, q, r) in &rods[a] {
            for &(u, v, s) in &rods[b] {
                let [x, y] = nearest_points([p, q], [u, v]);
                let depth = r + s - (x - y).norm();
                if depth > worst.map_or(f64::NEG_INFINITY, |w| w.depth) {
                    worst = Some(Overlap { bodies: [a, b], depth });
                }
            }
        }
    }
    worst
}

/// A shape as a segment with a radius, in the body's frame `[m]`. A box is the largest capsule along its longest side.
pub fn rod(shape: &Shape) -> ([f64; 3], [f64; 3], f64) {
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

/// The nearest points of two segments: those of their lines, put back onto each segment in turn (Ericson, Real-Time Collision Detection,
/// 5.1.9). Of parallel ones those about the first one's middle.
pub(crate) fn nearest_points(a: [Vec3<f64>; 2], b: [Vec3<f64>; 2]) -> [Vec3<f64>; 2] {
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

    fn distance(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
        let [p, q] = nearest_points(a.map(Vec3), b.map(Vec3));
        (p - q).norm()
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

    #[test]
    fn nearest_points_of_segments_are_found() {
        let x = [Vec3([0.0, 0.0, 0.0]), Vec3([1.0, 0.0, 0.0])];
        let over = [Vec3([0.5, -1.0, 2.0]), Vec3([0.5, 1.0, 2.0])];
        let [p, q] = nearest_points(x, over);
        assert!((p - Vec3([0.5, 0.0, 0.0])).norm() < 1e-12 && (q - Vec3([0.5, 0.0, 2.0])).norm() < 1e-12);
        let beyond = [Vec3([3.0, 0.0, 0.0]), Vec3([5.0, 1.0, 0.0])];
        let [p, q] = nearest_points(x, beyond);
        assert!((p.x() - 1.0).abs() < 1e-12 && (q - beyond[0]).norm() < 1e-12);
        let beside = [Vec3([0.2, 3.0, 0.0]), Vec3([0.9, 3.0, 0.0])];
        let [p, q] = nearest_points(x, beside);
        assert!(((p - q).norm() - 3.0).abs() < 1e-12);
    }

    #[test]
    fn feet_next_to_each_other_are_as_far_apart_as_their_capsules() {
        let model = RobotModel::g1();
        let body = |name: &str| model.body_index(name).expect("a body");
        let feet = ["left_ankle_roll_link", "right_ankle_roll_link"].map(body);
        let pairs = leg_pairs(&model, feet);
        assert_eq!(pairs.len(), 4, "each foot and shin with the other's");
        assert!(pairs.contains(&(body("left_knee_link"), feet[1])));
        // All other bodies are meters away.
        let mut pos: Vec<[f64; 3]> =
            (0..model.bodies.len()).map(|i| [0.0, 0.0, 3.0 * (i + 1) as f64]).collect();
        let quat = vec![[1.0, 0.0, 0.0, 0.0]; model.bodies.len()];
        // Capsules of 3 cm whose middles are 8 cm apart, then 5 cm.
        (pos[feet[0]], pos[feet[1]]) = ([0.0; 3], [0.0, -0.08, 0.0]);
        let nearest = deepest(&rods(&model, &pos, &quat), &pairs).expect("a pair");
        assert_eq!(nearest.bodies, feet);
        assert!((nearest.depth + 0.02).abs() < 1e-12, "{nearest:?}");
        pos[feet[1]] = [0.0, -0.05, 0.0];
        let overlap = deepest(&rods(&model, &pos, &quat), &pairs).expect("they touch");
        assert!((overlap.depth - 0.01).abs() < 1e-12, "{overlap:?}");
        // A pair before it whose distance is no number hides nothing.
        let shin = body("left_knee_link");
        pos[shin] = [f64::NAN; 3];
        let first = [(shin, feet[1]), (feet[0], feet[1])];
        assert_eq!(deepest(&rods(&model, &pos, &quat), &first), Some(overlap));
    }
}
