//! Distances of line segments.

use paid_lanes::{Real, Vec3};

/// Nearest points of two segments, given their ends, squared lengths and the reciprocals of these (0 for a point). Any frame and
/// unit (Ericson, "Real-Time Collision Detection", 5.1.9). Of parallel segments: the middle of the first, if it faces the second.
#[inline(always)]
pub fn nearest_points<V: Real>(
    a: &[Vec3<V>; 2],
    b: &[Vec3<V>; 2],
    length2: [V; 2],
    inv_length2: [V; 2],
) -> [Vec3<V>; 2] {
    let (zero, one) = (V::zero(), V::one());
    let along_a = a[1] - a[0];
    let along_b = b[1] - b[0];
    let apart = a[0] - b[0];
    let [length_a, length_b] = length2;
    let mixed = along_a.dot(along_b);
    let (c, f) = (along_a.dot(apart), along_b.dot(apart));
    let det = mixed.neg_mul_add(mixed, length_a * length_b);
    let parallel = det.le(length_a * length_b * V::c(1e-5));
    let s = mixed.mul_add(f, -(c * length_b)) * V::select(parallel, one, det).recip();
    let s = V::select(parallel, V::c(0.5), s).clamp(zero, one);
    let t = (mixed.mul_add(s, f) * inv_length2[1]).clamp(zero, one);
    let s = (mixed.mul_add(t, -c) * inv_length2[0]).clamp(zero, one);
    [along_a.scale_add(s, a[0]), along_b.scale_add(t, b[0])]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn apart(a: [[f64; 3]; 2], b: [[f64; 3]; 2]) -> f64 {
        let [a, b] = [a, b].map(|ends| ends.map(Vec3));
        let length2 = [(a[1] - a[0]).norm2(), (b[1] - b[0]).norm2()];
        let [p, q] = nearest_points(&a, &b, length2, length2.map(|l| if l > 0.0 { 1.0 / l } else { 0.0 }));
        (p - q).norm()
    }

    #[test]
    fn crossed_parallel_distant_and_empty_segments_have_their_distances() {
        let x = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]];
        // Crossed above each other, side by side, end to end, and a point beyond an end: 3 along x and 4 along y.
        assert_eq!(apart(x, [[0.5, -1.0, 0.3], [0.5, 1.0, 0.3]]), 0.3);
        assert_eq!(apart(x, [[-1.0, 0.2, 0.0], [1.0, 0.2, 0.0]]), 0.2);
        assert_eq!(apart(x, [[1.5, 0.0, 0.0], [3.0, 0.0, 0.0]]), 0.5);
        assert_eq!(apart(x, [[4.0, 4.0, 0.0], [4.0, 4.0, 0.0]]), 5.0);
    }
}
