//! Parts of the robot that the LiDAR sees.

use nalgebra::Vector3;

/// A cylinder with round ends.
#[derive(Clone, Copy, Debug)]
pub struct Capsule {
    /// One end of the axis `[m]`.
    pub from: Vector3<f64>,
    /// The other end `[m]`.
    pub to: Vector3<f64>,
    /// Radius `[m]`.
    pub radius: f64,
}

impl Capsule {
    /// Distance `[m]` along the unit vector `ray` from `origin` to the surface, if the ray meets it from outside.
    #[must_use]
    pub fn range(&self, origin: &Vector3<f64>, ray: &Vector3<f64>) -> Option<f64> {
        let axis = self.to - self.from;
        let from = origin - self.from;
        let square = axis.norm_squared();
        let (along_ray, along_from) = (axis.dot(ray), axis.dot(&from));
        // The cylinder: |from + t ray|^2 less its part along the axis is r^2.
        let a = square - along_ray * along_ray;
        let b = square * from.dot(ray) - along_from * along_ray;
        let c = square * (from.norm_squared() - self.radius * self.radius) - along_from * along_from;
        let root = b * b - a * c;
        if root < 0.0 {
            return None;
        }
        if a > 1e-12 {
            let range = (-b - root.sqrt()) / a;
            let along = along_from + range * along_ray;
            if range > 0.0 && (0.0..=square).contains(&along) {
                return Some(range);
            }
        }
        [self.from, self.to]
            .iter()
            .filter_map(|end| sphere(&(origin - end), ray, self.radius))
            .reduce(f64::min)
    }
}

fn sphere(from: &Vector3<f64>, ray: &Vector3<f64>, radius: f64) -> Option<f64> {
    let b = from.dot(ray);
    let root = b * b - from.norm_squared() + radius * radius;
    let range = -b - root.max(0.0).sqrt();
    (root >= 0.0 && range > 0.0).then_some(range)
}

/// Arms and legs of a walking G1 in its torso frame: `swing` from -1 to 1 is how far the left arm and the right leg are ahead.
#[must_use]
pub(crate) fn limbs(swing: f64) -> [Capsule; 6] {
    let arm = |side: f64| {
        let ahead = 0.25 * swing * side;
        let shoulder = Vector3::new(0.0, 0.12 * side, 0.29);
        let elbow = Vector3::new(ahead, 0.2 * side, 0.08);
        let hand = Vector3::new(ahead + 0.22, 0.18 * side, 0.02 + 0.2 * ahead);
        [
            Capsule { from: shoulder, to: elbow, radius: 0.05 },
            Capsule { from: elbow, to: hand, radius: 0.045 },
        ]
    };
    let leg = |side: f64| Capsule {
        from: Vector3::new(0.0, 0.1 * side, -0.15),
        to: Vector3::new(-0.25 * swing * side, 0.12 * side, -0.75),
        radius: 0.07,
    };
    let [[a, b], [c, d]] = [arm(1.0), arm(-1.0)];
    [a, b, c, d, leg(1.0), leg(-1.0)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_meet_the_side_and_the_round_ends() {
        let capsule = Capsule { from: Vector3::zeros(), to: Vector3::z(), radius: 0.1 };
        let x = Vector3::x();
        let near = |found: Option<f64>, wanted: f64| found.is_some_and(|f| (f - wanted).abs() < 1e-12);
        assert!(near(capsule.range(&Vector3::new(-1.0, 0.0, 0.5), &x), 0.9));
        assert!(near(capsule.range(&Vector3::new(0.0, 0.0, 3.0), &-Vector3::z()), 1.9));
        // At half of the radius above the end the round end is 0.1 x sqrt(3)/2 wide.
        let found = capsule.range(&Vector3::new(-1.0, 0.0, 1.05), &x);
        assert!(near(found, 1.0 - 0.1 * 0.75_f64.sqrt()), "{found:?}");
        assert_eq!(capsule.range(&Vector3::new(-1.0, 0.0, 1.2), &x), None);
        assert_eq!(capsule.range(&Vector3::new(1.0, 0.0, 0.5), &x), None);
    }
}
