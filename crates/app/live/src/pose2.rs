//! Places on the ground: between the engine's world and the pitch that the visitor sees.

/// A place on the ground and a heading, in other axes: x, y `[m]` and the angle about the vertical `[rad]`.
///
/// The pitch's axes: the robot begins at the origin and looks along x, y is left, z is up.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose2 {
    /// Origin (x, y) `[m]`.
    pub xy: [f64; 2],
    /// Heading `[rad]`.
    pub heading: f64,
}

/// `v` turned by `angle` `[rad]`.
pub fn turned(v: [f64; 2], angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * v[0] - s * v[1], s * v[0] + c * v[1]]
}

/// `angle` between -pi and pi `[rad]`.
pub fn wrapped(angle: f64) -> f64 {
    let (s, c) = angle.sin_cos();
    s.atan2(c)
}

impl Pose2 {
    /// A point of this pose's axes, in the axes around it `[m]`.
    pub fn point(&self, p: [f64; 2]) -> [f64; 2] {
        let [x, y] = turned(p, self.heading);
        [self.xy[0] + x, self.xy[1] + y]
    }

    /// A point of the axes around, in this pose's axes `[m]`.
    pub fn local(&self, p: [f64; 2]) -> [f64; 2] {
        turned([p[0] - self.xy[0], p[1] - self.xy[1]], -self.heading)
    }

    /// A pose in this pose's axes, in the axes around it.
    pub fn pose(&self, inner: &Self) -> Self {
        Self { xy: self.point(inner.xy), heading: wrapped(self.heading + inner.heading) }
    }

    /// The pose of axes in which `from` is where this pose is: `result.pose(from) == self`.
    pub fn over(&self, from: &Self) -> Self {
        let heading = wrapped(self.heading - from.heading);
        let [x, y] = turned(from.xy, heading);
        Self { xy: [self.xy[0] - x, self.xy[1] - y], heading }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn near(a: [f64; 2], b: [f64; 2]) {
        assert!((a[0] - b[0]).hypot(a[1] - b[1]) < 1e-12, "{a:?}, expected {b:?}");
    }

    #[test]
    fn a_point_ahead_of_a_pose_that_looks_along_y_is_further_along_y() {
        let pose = Pose2 { xy: [1.0, 2.0], heading: FRAC_PI_2 };
        near(pose.point([3.0, 0.5]), [0.5, 5.0]);
        near(pose.local([0.5, 5.0]), [3.0, 0.5]);
    }

    #[test]
    fn axes_are_laid_over_a_pose() {
        let (here, there) =
            (Pose2 { xy: [1.0, 2.0], heading: FRAC_PI_2 }, Pose2 { xy: [-3.0, 0.0], heading: 0.25 });
        let axes = here.over(&there);
        let back = axes.pose(&there);
        near(back.xy, here.xy);
        assert!((back.heading - here.heading).abs() < 1e-12);
        near(axes.point([-3.0, 0.0]), [1.0, 2.0]);
    }
}
