//! Terms about the ball.

use paid_lanes::{Mask, Real, Vec3};

use super::tracking::gaussian;

/// Nearness: `exp(-d_xy^2 / sigma^2)` of a point of the robot and the ball.
#[inline(always)]
pub(crate) fn proximity<V: Real>(point: Vec3<V>, ball: Vec3<V>, sigma: f64) -> V {
    let (dx, dy) = (ball.x() - point.x(), ball.y() - point.y());
    gaussian(dx.mul_add(dx, dy * dy), sigma)
}

/// Share of the foot's speed that swings inwards: `max(0, v_y s) / |v|`, v in the foot's axes, s = -1 for the left and +1 for
/// the right foot; 0 for a resting foot.
#[inline(always)]
pub(crate) fn side_kick<V: Real>(foot_vel_in_foot: Vec3<V>, side: V) -> V {
    let speed = foot_vel_in_foot.norm();
    let lateral = (foot_vel_in_foot.y() * side).max(V::zero());
    V::select(speed.gt(V::c(1e-4)), lateral / speed.max(V::c(1e-4)), V::zero())
}

/// Direction: `exp(-angle^2 / sigma^2)` between the ball's horizontal velocity and the way from where it lay to the goal.
#[inline(always)]
pub(crate) fn alignment<V: Real>(ball_vel: Vec3<V>, from: Vec3<V>, goal: Vec3<V>, sigma: f64) -> V {
    let (gx, gy) = (goal.x() - from.x(), goal.y() - from.y());
    let cross = gx * ball_vel.y() - gy * ball_vel.x();
    let dot = gx * ball_vel.x() + gy * ball_vel.y();
    let angle = cross.abs().atan2(dot);
    gaussian(angle * angle, sigma)
}

/// Share of the direction's pay that a ball of horizontal `speed` earns: `min(1, speed / full)`, 1 if `full` is 0 [m/s].
#[inline(always)]
pub(crate) fn speed_share<V: Real>(speed: V, full: f64) -> V {
    if full > 0.0 { (speed * V::c(1.0 / full)).min(V::one()) } else { V::one() }
}

/// Horizontal speed: `1 - exp(-v_xy^2 / sigma^2)`.
#[inline(always)]
pub(crate) fn planar_speed<V: Real>(ball_vel: Vec3<V>, sigma: f64) -> V {
    let (x, y) = (ball_vel.x(), ball_vel.y());
    V::one() - gaussian(x.mul_add(x, y * y), sigma)
}

/// Vertical speed: `tanh(|v_z| / scale)`.
#[inline(always)]
pub(crate) fn vertical_speed<V: Real>(ball_vel: Vec3<V>, scale: f64) -> V {
    (ball_vel.z().abs() * V::c(1.0 / scale)).tanh()
}

/// True if `ball` is past the plane through `goal` perpendicular to the heading, and within `half_width` of its center.
#[inline(always)]
pub(crate) fn past_goal_plane<V: Real>(
    ball: Vec3<V>,
    goal: Vec3<V>,
    heading: [V; 2],
    half_width: f64,
) -> (V::Mask, V::Mask) {
    let (dx, dy) = (ball.x() - goal.x(), ball.y() - goal.y());
    let along = dx * heading[0] + dy * heading[1];
    let across = dy * heading[0] - dx * heading[1];
    let past = along.ge(V::zero());
    (past, past.and(across.abs().le(V::c(half_width))))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-9, "{a} {b}");
    }

    #[test]
    fn proximity_ignores_height() {
        close(proximity(Vec3([0.0, 0.0, 0.8]), Vec3([0.0, 4.0, 0.1]), 4.0), (-1.0_f64).exp());
    }

    #[test]
    fn a_side_kick_swings_inwards() {
        close(side_kick(Vec3([3.0, 4.0, 0.0]), 1.0), 0.8);
        close(side_kick(Vec3([3.0, 4.0, 0.0]), -1.0), 0.0);
        close(side_kick(Vec3([3.0, -4.0, 0.0]), -1.0), 0.8);
        close(side_kick(Vec3([0.0; 3]), 1.0), 0.0);
    }

    #[test]
    fn alignment_measures_the_horizontal_angle() {
        let from = Vec3([1.0, 0.0, 0.1]);
        let goal = Vec3([1.0, 5.0, 0.1]);
        close(alignment(Vec3([0.0, 3.0, 2.0]), from, goal, 0.8), 1.0);
        let angle = core::f64::consts::FRAC_PI_4;
        close(alignment(Vec3([2.0, 2.0, 0.0]), from, goal, 0.8), (-(angle * angle) / 0.64).exp());
    }

    #[test]
    fn a_slow_ball_earns_its_share_of_the_direction() {
        close(speed_share(1.0, 2.5), 0.4);
        close(speed_share(4.0, 2.5), 1.0);
        close(speed_share(0.0, 0.0), 1.0);
    }

    #[test]
    fn speeds_saturate() {
        close(planar_speed(Vec3([0.0, 1.2, 9.0]), 1.2), 1.0 - (-1.0_f64).exp());
        close(planar_speed(Vec3([0.0; 3]), 1.2), 0.0);
        close(vertical_speed(Vec3([9.0, 9.0, -3.0]), 3.0), 1.0_f64.tanh());
    }

    #[test]
    fn the_goal_is_crossed_within_its_width_only() {
        // Heading -y, goal at (0, -5).
        let (goal, heading) = (Vec3([0.0, -5.0, 0.1]), [0.0, -1.0]);
        assert_eq!(past_goal_plane(Vec3([0.9, -5.1, 0.1]), goal, heading, 1.0), (true, true));
        assert_eq!(past_goal_plane(Vec3([1.1, -5.1, 0.1]), goal, heading, 1.0), (true, false));
        assert_eq!(past_goal_plane(Vec3([0.0, -4.9, 0.1]), goal, heading, 1.0), (false, false));
    }
}
