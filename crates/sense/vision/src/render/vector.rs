//! Three `f32`: a renderer needs no more.

/// A point, a direction or a linear color.
pub type V3 = [f32; 3];

#[inline(always)]
pub(super) fn dot(a: V3, b: V3) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn scale(a: V3, k: f32) -> V3 {
    [a[0] * k, a[1] * k, a[2] * k]
}

#[inline(always)]
pub(super) fn mix(a: V3, b: V3, share: f32) -> V3 {
    add(scale(a, 1.0 - share), scale(b, share))
}

#[inline(always)]
pub(super) fn unit(a: V3) -> V3 {
    scale(a, 1.0 / dot(a, a).max(1e-20).sqrt())
}

/// Rows times a vector.
#[inline(always)]
pub(super) fn rotate(m: &[V3; 3], v: V3) -> V3 {
    [dot(m[0], v), dot(m[1], v), dot(m[2], v)]
}

/// Columns times a vector.
#[inline(always)]
pub(super) fn rotate_back(m: &[V3; 3], v: V3) -> V3 {
    add(scale(m[0], v[0]), add(scale(m[1], v[1]), scale(m[2], v[2])))
}

/// 0 below `from`, 1 above `to`, smooth between.
#[inline(always)]
pub(super) fn smooth(from: f32, to: f32, x: f32) -> f32 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
