//! What is in a camera's image.

use paid_lanes::{Mask, Real, Vec3};
use serde::{Deserialize, Serialize};

use crate::ValueError;
use crate::error::within;

/// Where a camera is and how wide it sees.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPreset {
    /// Place in the frame of the body that carries it `[m]`.
    pub mount_m: [f64; 3],
    /// Angle of the optical axis below the body's x axis `[degrees]`.
    pub down_deg: f64,
    /// Full angle of the image across `[degrees]`.
    pub across_deg: f64,
    /// Full angle of the image from top to bottom `[degrees]`.
    pub upright_deg: f64,
}

impl Default for CameraPreset {
    /// The Unitree G1's depth camera, 1.27 m above the ground on straight legs (the torso's frame is then 0.84 m up).
    fn default() -> Self {
        Self { mount_m: [0.058, 0.018, 0.43], down_deg: 47.6, across_deg: 87.0, upright_deg: 58.0 }
    }
}

impl CameraPreset {
    /// The color image of the same camera, 69 x 42 degrees: color tells a ball from other things.
    pub fn color() -> Self {
        Self { across_deg: 69.0, upright_deg: 42.0, ..Self::default() }
    }

    /// What is in the camera's image, in the body's frame.
    pub fn geometry(&self) -> Camera {
        Camera::new(self.mount_m, self.down_deg, self.across_deg, self.upright_deg)
    }

    /// Checks every value.
    ///
    /// # Errors
    /// The first value that is out of range.
    pub fn check(&self) -> Result<(), ValueError> {
        within("across_deg", self.across_deg, [1.0, 179.0], "1 to 179 degrees")?;
        within("upright_deg", self.upright_deg, [1.0, 179.0], "1 to 179 degrees")?;
        within("down_deg", self.down_deg, [-90.0, 90.0], "-90 to 90 degrees")?;
        match self.mount_m.iter().find(|x| !x.is_finite()) {
            Some(found) => Err(ValueError::new("mount_m", "finite numbers", found)),
            None => Ok(()),
        }
    }
}

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
    /// A camera at `mount_m` in the body frame `[m]`. Its axis points `down_deg` below the body's x axis; the image opens by
    /// `across_deg` from left to right and by `upright_deg` from top to bottom (full angles, degrees).
    pub fn new(mount_m: [f64; 3], down_deg: f64, across_deg: f64, upright_deg: f64) -> Self {
        let (sin, cos) = down_deg.to_radians().sin_cos();
        let half = |degrees: f64| (0.5 * degrees.to_radians()).tan();
        Self { mount: mount_m, down: [sin, cos], half: [half(across_deg), half(upright_deg)] }
    }

    /// Where a point of the body frame `[m]` is inside the image.
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

    /// Place in the body frame `[m]`.
    #[inline(always)]
    pub fn mount<V: Real>(&self) -> Vec3<V> {
        Vec3::c(self.mount)
    }

    /// The ray through a point of the image, body frame, of depth 1: `left` is -1 at the right edge and 1 at the left one, `up` -1 at
    /// the lower edge and 1 at the upper one.
    #[inline(always)]
    pub fn ray<V: Real>(&self, left: V, up: V) -> Vec3<V> {
        let (sin, cos) = (V::c(self.down[0]), V::c(self.down[1]));
        let up = up * V::c(self.half[1]);
        Vec3([up.mul_add(sin, cos), left * V::c(self.half[0]), up.mul_add(cos, -sin)])
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
    fn a_ray_ends_in_the_picture_where_it_was_sent() {
        // Through the middle: along the axis, 47.6 degrees below the horizontal.
        let axis: Vec3<f64> = head().ray(0.0, 0.0);
        let down = 47.6_f64.to_radians();
        assert!((axis.x() - down.cos()).abs() < 1e-12 && (axis.z() + down.sin()).abs() < 1e-12);
        for (left, up, seen) in
            [(0.99, 0.99, true), (-0.99, -0.99, true), (1.01, 0.0, false), (0.0, 1.01, false)]
        {
            let point = head().mount() + head().ray(left, up).scale(2.0);
            assert_eq!(head().sees::<f64>(point), seen, "{left} {up}");
        }
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
