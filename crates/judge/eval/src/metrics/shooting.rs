//! Where the ball went.

/// The goal: a vertical plane with a mouth of finite width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Goal {
    /// Center, world `[m]`.
    pub center: [f64; 2],
    /// Heading of the shooting direction `[rad]`: the plane is perpendicular to it.
    pub heading: f64,
    /// Half of the mouth `[m]`.
    pub half_width: f64,
}

/// The ball's first passage through the goal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Distance from the center along the plane, left positive `[m]`.
    pub lateral: f64,
    /// Share of the interval between the two positions that had passed.
    pub share: f64,
    /// True if it went through the mouth; a ball whose center meets a post exactly is in.
    pub inside: bool,
}

impl Goal {
    /// Coordinates of a point: distance past the plane (negative in front of it) and along it, left positive `[m]`.
    pub fn local(&self, point: [f64; 2]) -> [f64; 2] {
        let (s, c) = self.heading.sin_cos();
        let (dx, dy) = (point[0] - self.center[0], point[1] - self.center[1]);
        [c * dx + s * dy, c * dy - s * dx]
    }

    /// The passage between two successive positions of the ball's center, from in front of the plane onto or past it, on a
    /// straight line; `None` if there is none. A ball that starts on or behind the plane does not pass it.
    pub fn crossing(&self, before: [f64; 2], after: [f64; 2]) -> Option<Crossing> {
        let (a, b) = (self.local(before), self.local(after));
        if !(a[0] < 0.0 && b[0] >= 0.0) {
            return None;
        }
        let share = a[0] / (a[0] - b[0]);
        let lateral = a[1] + (b[1] - a[1]) * share;
        Some(Crossing { lateral, share, inside: lateral.abs() <= self.half_width })
    }
}

/// Cosine between the ball's horizontal outgoing velocity and the direction from the ball at impact to the goal's
/// center; `None` if the ball does not move or lies at the center.
pub fn direction_cosine(velocity: [f64; 2], ball_at_impact: [f64; 2], goal: [f64; 2]) -> Option<f64> {
    let to_goal = [goal[0] - ball_at_impact[0], goal[1] - ball_at_impact[1]];
    let lengths = velocity[0].hypot(velocity[1]) * to_goal[0].hypot(to_goal[1]);
    (lengths > 1e-9).then(|| (velocity[0] * to_goal[0] + velocity[1] * to_goal[1]) / lengths)
}

/// True if the base lies rather than stands: its height above the ground is below half of the nominal one, or it is tilted more than 60 degrees.
pub fn fallen(base_height_m: f64, base_up_z: f64, nominal_height_m: f64) -> bool {
    base_height_m < 0.5 * nominal_height_m || base_up_z < 0.5
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    const AHEAD: Goal = Goal { center: [5.0, 0.0], heading: 0.0, half_width: 1.0 };

    #[test]
    fn the_crossing_point_decides_not_the_position_after() {
        // At the plane the ball is 0.95 m left of the center; one step later it is wide.
        let crossing = AHEAD.crossing([4.9, 0.9], [5.1, 1.0]).expect("crosses");
        assert!(crossing.inside && (crossing.lateral - 0.95).abs() < 1e-12);
        assert!((crossing.share - 0.5).abs() < 1e-12);
        assert!(!AHEAD.crossing([4.9, 1.0], [5.1, 1.1]).expect("crosses").inside);
    }

    #[test]
    fn on_the_post_is_in_and_past_it_is_out() {
        assert!(AHEAD.crossing([4.0, -1.0], [6.0, -1.0]).expect("crosses").inside);
        assert!(!AHEAD.crossing([4.0, -1.001], [6.0, -1.001]).expect("crosses").inside);
    }

    #[test]
    fn a_ball_that_stops_on_the_plane_has_crossed_and_one_before_it_has_not() {
        assert!(AHEAD.crossing([4.99, 0.0], [5.0, 0.0]).is_some());
        assert!(AHEAD.crossing([4.99, 0.0], [4.999, 0.0]).is_none());
        assert!(AHEAD.crossing([4.99, 0.0], [4.99, 0.0]).is_none(), "a ball at rest");
    }

    #[test]
    fn a_ball_behind_the_plane_never_scores() {
        assert!(AHEAD.crossing([5.5, 0.0], [4.5, 0.0]).is_none(), "from behind");
        assert!(AHEAD.crossing([5.5, 0.0], [6.0, 0.0]).is_none(), "already past");
        assert!(AHEAD.crossing([5.0, 0.0], [6.0, 0.0]).is_none(), "starts on it");
    }

    #[test]
    fn the_plane_faces_the_robot_whatever_its_heading() {
        // Facing -y, as in the motion files: the goal is at (0, -5).
        let goal = Goal { center: [0.0, -5.0], heading: -FRAC_PI_2, half_width: 1.0 };
        let crossing = goal.crossing([0.5, -4.0], [0.5, -6.0]).expect("crosses");
        assert!(crossing.inside && (crossing.lateral - 0.5).abs() < 1e-12, "+x is left when facing -y");
        assert!(!goal.crossing([-1.5, -4.0], [-1.5, -6.0]).expect("crosses").inside);
    }

    #[test]
    fn accuracy_is_the_cosine_of_the_miss() {
        let cosine = |v| direction_cosine(v, [1.0, 0.0], [5.0, 0.0]);
        assert_eq!(cosine([3.0, 0.0]), Some(1.0));
        assert_eq!(cosine([0.0, 2.0]), Some(0.0));
        assert_eq!(cosine([-1.0, 0.0]), Some(-1.0));
        assert!((cosine([1.0, 1.0]).expect("moves") - 0.5_f64.sqrt()).abs() < 1e-12);
        assert_eq!(cosine([0.0, 0.0]), None);
    }

    #[test]
    fn lying_is_low_or_tilted() {
        assert!(!fallen(0.7, 0.95, 0.76));
        assert!(fallen(0.37, 0.95, 0.76));
        assert!(fallen(0.7, 0.49, 0.76));
    }
}
