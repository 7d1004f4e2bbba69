//! Things in a scene.

use super::paint::Paint;
use super::vector::{V3, add, dot, rotate, rotate_back, scale, sub, unit};

/// The form of a thing, world frame `[m]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A ball.
    Sphere {
        /// Center.
        center: V3,
        /// Radius.
        radius: f32,
    },
    /// All points within `radius` of the segment.
    Capsule {
        /// The segment's ends.
        ends: [V3; 2],
        /// Radius.
        radius: f32,
    },
    /// A cuboid.
    Box {
        /// Center.
        center: V3,
        /// Half extents along its own axes.
        half_size: V3,
        /// Its axes in the world, unit vectors.
        axes: [V3; 3],
    },
}

/// A thing in a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solid {
    /// Form and place at the middle of the exposure.
    pub form: Form,
    /// What it looks like.
    pub paint: Paint,
    /// How fast it moves, world axes `[m/s]`.
    pub velocity: V3,
}

impl Form {
    /// The same form in the frame of a camera at `eye` whose axes are the rows of `axes`.
    pub(super) fn seen_from(&self, eye: V3, axes: &[V3; 3]) -> Self {
        let place = |point: V3| rotate(axes, sub(point, eye));
        match *self {
            Form::Sphere { center, radius } => Form::Sphere { center: place(center), radius },
            Form::Capsule { ends, radius } => Form::Capsule { ends: ends.map(place), radius },
            Form::Box { center, half_size, axes: own } => {
                Form::Box { center: place(center), half_size, axes: own.map(|axis| rotate(axes, axis)) }
            }
        }
    }

    /// The form moved by a vector.
    #[inline(always)]
    pub(super) fn moved(&self, by: V3) -> Self {
        match *self {
            Form::Sphere { center, radius } => Form::Sphere { center: add(center, by), radius },
            Form::Capsule { ends, radius } => Form::Capsule { ends: ends.map(|end| add(end, by)), radius },
            Form::Box { center, half_size, axes } => Form::Box { center: add(center, by), half_size, axes },
        }
    }

    /// Whether a point is inside, or closer to it than `margin` `[m]`.
    pub(super) fn holds(&self, point: V3, margin: f32) -> bool {
        match *self {
            Form::Sphere { center, radius } => {
                let d = sub(point, center);
                dot(d, d) < (radius + margin).powi(2)
            }
            Form::Capsule { ends: [a, b], radius } => {
                let (ab, ap) = (sub(b, a), sub(point, a));
                let along = (dot(ap, ab) / dot(ab, ab).max(1e-12)).clamp(0.0, 1.0);
                let d = sub(ap, scale(ab, along));
                dot(d, d) < (radius + margin).powi(2)
            }
            Form::Box { center, half_size, axes } => {
                let d = rotate(&axes, sub(point, center));
                (0..3).all(|k| d[k].abs() < half_size[k] + margin)
            }
        }
    }

    /// Where a ray from the origin first meets the form from outside, as a multiple of `ray`; infinity if it does not.
    #[inline(always)]
    pub(super) fn hit(&self, ray: V3) -> f32 {
        match *self {
            Form::Sphere { center, radius } => sphere_hit(ray, center, radius),
            Form::Capsule { ends, radius } => capsule_hit(ray, ends, radius),
            Form::Box { center, half_size, axes } => {
                let (from, along) = (rotate(&axes, center), rotate(&axes, ray));
                let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
                for k in 0..3 {
                    let inverse = 1.0 / along[k];
                    let (a, b) = ((from[k] - half_size[k]) * inverse, (from[k] + half_size[k]) * inverse);
                    near = near.max(a.min(b));
                    far = far.min(a.max(b));
                }
                if near <= far && near > 0.0 { near } else { f32::INFINITY }
            }
        }
    }

    /// The outward normal at a point of the surface.
    #[inline(always)]
    pub(super) fn normal(&self, point: V3) -> V3 {
        match *self {
            Form::Sphere { center, radius } => scale(sub(point, center), 1.0 / radius),
            Form::Capsule { ends: [a, b], radius } => {
                let (ab, ap) = (sub(b, a), sub(point, a));
                let along = (dot(ap, ab) / dot(ab, ab).max(1e-12)).clamp(0.0, 1.0);
                scale(sub(ap, scale(ab, along)), 1.0 / radius)
            }
            Form::Box { center, half_size, axes } => {
                let d = rotate(&axes, sub(point, center));
                let share = [0, 1, 2].map(|k| d[k].abs() / half_size[k]);
                let k = (0..3).fold(0, |best, k| if share[k] > share[best] { k } else { best });
                let mut own = [0.0; 3];
                own[k] = 1.0_f32.copysign(d[k]);
                unit(rotate_back(&axes, own))
            }
        }
    }
}

#[inline(always)]
fn sphere_hit(ray: V3, center: V3, radius: f32) -> f32 {
    let (a, b) = (dot(ray, ray), dot(ray, center));
    // The squared distance of the ray from the center, without the cancellation of b^2 - a c.
    let miss = sub(center, scale(ray, b / a));
    let inside = radius * radius - dot(miss, miss);
    if inside < 0.0 || b <= 0.0 {
        return f32::INFINITY;
    }
    let t = (b - (inside * a).sqrt()) / a;
    if t > 0.0 { t } else { f32::INFINITY }
}

#[inline(always)]
fn capsule_hit(ray: V3, [a, b]: [V3; 2], radius: f32) -> f32 {
    let axis = sub(b, a);
    let (axis2, along_ray, along_a) = (dot(axis, axis), dot(axis, ray), -dot(axis, a));
    // The part of ray and start across the axis; |start + t ray| = radius there is the cylinder.
    let across_ray = sub(ray, scale(axis, along_ray / axis2));
    let across_a = sub(scale(a, -1.0), scale(axis, along_a / axis2));
    let (qa, qb) = (dot(across_ray, across_ray), dot(across_ray, across_a));
    let qc = dot(across_a, across_a) - radius * radius;
    let inside = qb * qb - qa * qc;
    if inside < 0.0 {
        return f32::INFINITY;
    }
    if qa > 1e-12 {
        let t = (-qb - inside.sqrt()) / qa;
        let place = along_a + t * along_ray;
        if t > 0.0 && place >= 0.0 && place <= axis2 {
            return t;
        }
        return sphere_hit(ray, if place < 0.0 { a } else { b }, radius);
    }
    sphere_hit(ray, a, radius).min(sphere_hit(ray, b, radius))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_near_side() {
        let close =
            |found: f32, expected: f32| assert!((found - expected).abs() < 1e-5, "{found} {expected}");
        let ahead = [0.0, 0.0, 1.0];
        close(Form::Sphere { center: [0.0, 0.0, 3.0], radius: 0.5 }.hit(ahead), 2.5);
        // Half its radius off the axis: sqrt(0.25 - 0.0625) before the center.
        close(Form::Sphere { center: [0.25, 0.0, 3.0], radius: 0.5 }.hit(ahead), 3.0 - 0.433_012_7);
        assert!(Form::Sphere { center: [0.0, 0.0, -3.0], radius: 0.5 }.hit(ahead).is_infinite());
        let lying = Form::Capsule { ends: [[-1.0, 0.0, 2.0], [1.0, 0.0, 2.0]], radius: 0.2 };
        close(lying.hit(ahead), 1.8);
        let end_on = Form::Capsule { ends: [[0.0, 0.0, 2.0], [0.0, 0.0, 4.0]], radius: 0.2 };
        close(end_on.hit(ahead), 1.8);
        // Next to the end: the cap, not the cylinder.
        close(
            Form::Capsule { ends: [[0.1, 0.0, 2.0], [1.0, 0.0, 2.0]], radius: 0.2 }.hit(ahead),
            2.0 - 0.173_205,
        );
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let cube = Form::Box { center: [0.1, 0.0, 2.0], half_size: [0.5; 3], axes };
        close(cube.hit(ahead), 1.5);
        assert_eq!(cube.normal([0.0, 0.0, 1.5]), [0.0, 0.0, -1.0]);
        assert!(cube.hit([1.0, 0.0, 1.0]).is_infinite());
    }

    #[test]
    fn normals_point_outward() {
        let capsule = Form::Capsule { ends: [[0.0, 0.0, 1.0], [0.0, 0.0, 2.0]], radius: 0.5 };
        assert_eq!(capsule.normal([0.5, 0.0, 1.3]), [1.0, 0.0, 0.0]);
        assert_eq!(capsule.normal([0.0, 0.0, 0.5]), [0.0, 0.0, -1.0]);
        assert!(capsule.holds([0.0, 0.4, 1.5], 0.0) && !capsule.holds([0.0, 0.6, 1.5], 0.0));
    }
}
