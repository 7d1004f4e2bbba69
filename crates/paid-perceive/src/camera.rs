//! What a camera has in its picture.

use paid_lanes::{Mask, Real, Vec3};

/// A pinhole camera fixed to a body, its optical axis in the body's x-z plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Place in the body frame `[m]`.
    mount: [f64; 3],
    /// Sine and cosine of the optical axis's angle below the body's x axis.
    down: [f64; 2],
    /// Tangents of half the opening angle, across and upright.
    half: [f64; 2],
}

impl Camera {
    /// A camera at `mount_m` in the body frame `[m]`. Its axis points `down_deg` below the body's x axis; the picture opens by
    /// `across_deg` from left to right and by `upright_deg` from top to bottom (full angles, degrees).
    pub fn new(mount_m: [f64; 3], down_deg: f64, across_deg: f64, upright_deg: f64) -> Self {
        let (sin, cos) = down_deg.to_radians().sin_cos();
        let half = |degrees: f64| (0.5 * degrees.to_radians()).tan();
        Self { mount: mount_m, down: [sin, cos], half: [half(across_deg), half(upright_deg)] }
    }

    /// Where a point of the body frame `[m]` is inside the picture.
    #[inline(always)]
    pub fn sees<V: Real>(&self, point: Vec3<V>) -> V::Mask {
        let from_mount = point - Vec3::c(self.mount);
        let (sin, cos) = (V::c(self.down[0]), V::c(self.down[1]));
        let depth = cos * from_mount.x() - sin * from_mount.z();
        let up = sin * from_mount.x() + cos * from_mount.z();
        let ahead = depth.gt(V::zero());
        let across = from_mount.y().abs().le(depth * V::c(self.half[0]));
        let upright = up.abs().le(depth * V::c(self.half[1]));
        ahead.and(across).and(upright)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::F32Array;

    /// The Unitree G1's depth camera on the torso.
    fn head() -> Camera {
        Camera::new([0.058, 0.018, 0.43], 47.6, 87.0, 58.0)
    }

    #[test]
    fn the_camera_sees_the_ground_before_the_feet_and_neither_far_nor_aside() {
        // Upright on straight legs the torso's frame is 0.84 m above the ground.
        let ball = |ahead: f64, left: f64| head().sees(Vec3([ahead, left, 0.11 - 0.84]));
        assert!((head().mount[2] + 0.84 - 1.27).abs() < 1e-9);
        // The band's edges: 76.6 and 18.6 degrees below the horizontal, 1.16 m above the ball.
        let edges = [76.6_f64, 18.6].map(|deg| head().mount[0] + 1.16 / deg.to_radians().tan());
        assert!(!ball(edges[0] - 0.02, 0.0) && ball(edges[0] + 0.02, 0.0));
        assert!(ball(edges[1] - 0.05, 0.0) && !ball(edges[1] + 0.05, 0.0), "{edges:?}");
        assert!(ball(1.0, 0.8) && !ball(1.0, 1.5) && !ball(-1.0, 0.0));
    }

    #[test]
    fn lanes_see_what_a_single_camera_sees() {
        let mut points = Vec3::<F32Array<8>>::zero();
        let places: Vec<[f64; 3]> = (0..8).map(|k| [0.4 * f64::from(k), 0.3, -0.73]).collect();
        for (lane, place) in places.iter().enumerate() {
            points.set_lane(lane, *place);
        }
        let seen = head().sees(points);
        for (lane, place) in places.iter().enumerate() {
            assert_eq!(seen.lane(lane), head().sees(Vec3(*place)), "{place:?}");
        }
        assert!(seen.any() && seen.bits() != 0xff);
    }
}
