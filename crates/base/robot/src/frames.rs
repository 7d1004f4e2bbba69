//! Angular velocities by frame: world and body axes do not mix.

use paid_lanes::{Mat3, Real, Vec3};

/// Angular velocity in world axes `[rad/s]`.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct WorldAngVel<V>(pub Vec3<V>);

/// Angular velocity in the axes of the turning body `[rad/s]`.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct BodyAngVel<V>(pub Vec3<V>);

impl<V: Real> WorldAngVel<V> {
    /// The same velocity in the axes of a body whose orientation is `world_from_body`.
    #[inline(always)]
    pub fn in_body(self, world_from_body: &Mat3<V>) -> BodyAngVel<V> {
        BodyAngVel(world_from_body.tr_mul_vec(self.0))
    }
}

impl<V: Real> BodyAngVel<V> {
    /// The same velocity in world axes; `world_from_body` is the body's orientation.
    #[inline(always)]
    pub fn in_world(self, world_from_body: &Mat3<V>) -> WorldAngVel<V> {
        WorldAngVel(world_from_body.mul_vec(self.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_lanes::Quat;

    #[test]
    fn a_body_turned_left_sees_the_worlds_x_axis_on_its_right() {
        let left = Quat::from_axis_angle(Vec3([0.0, 0.0, 1.0]), std::f64::consts::FRAC_PI_2).to_mat();
        let body = WorldAngVel(Vec3([2.0, 0.0, 0.5])).in_body(&left);
        for (found, expected) in body.0.0.into_iter().zip([0.0, -2.0, 0.5]) {
            assert!((found - expected).abs() < 1e-15);
        }
        for (found, expected) in body.in_world(&left).0.0.into_iter().zip([2.0, 0.0, 0.5]) {
            assert!((found - expected).abs() < 1e-15);
        }
    }
}
