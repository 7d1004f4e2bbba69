//! The choice of a motion for a ball.

use paid_track::effective_time;

use crate::MotionFacts;

/// A point given in a motion's start frame (origin: anchor at frame 0, x along its heading, y left), in the world `[m]`.
pub fn from_start_frame(facts: &MotionFacts, xy: [f64; 2]) -> [f64; 2] {
    let [x, y] = turned(xy, facts.heading);
    [facts.start_xy[0] + x, facts.start_xy[1] + y]
}

/// `xy` turned by `angle` `[rad]`.
pub fn turned(xy: [f64; 2], angle: f64) -> [f64; 2] {
    let (s, c) = angle.sin_cos();
    [c * xy[0] - s * xy[1], s * xy[0] + c * xy[1]]
}

/// The nominal ball: a motion's own place, world `[m]`.
pub fn nominal_ball(facts: &MotionFacts) -> [f64; 2] {
    [facts.start_xy[0] + facts.displacement[0], facts.start_xy[1] + facts.displacement[1]]
}

/// A motion's own place ([`crate::OwnPlace`]) in its start frame (x ahead, y left) `[m]`.
pub fn own_place(facts: &MotionFacts) -> [f64; 2] {
    turned(facts.displacement, -facts.heading)
}

/// The motion whose own place is nearest to a ball at `xy` in the start frame `[m]`; the first of equals (the public
/// evaluation's rule).
///
/// # Panics
/// If there are no motions.
pub fn nearest_motion(motions: &[MotionFacts], xy: [f64; 2]) -> usize {
    nearest(motions, |_| xy)
}

/// A ball when the robot begins, in axes of the horizontal plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingBall {
    /// Center `[m]`.
    pub place: [f64; 2],
    /// Velocity `[m/s]`.
    pub velocity: [f64; 2],
    /// Rate at which it slows down `[1/s]`, see [`paid_track::roll_decay`].
    pub decay: f64,
}

impl RollingBall {
    /// The ball by which motions are chosen: one whose policy does not see where it will be ([`crate::PlayPreset::predicts_ball`]) lies where it is.
    #[must_use]
    pub fn as_chosen_by(self, predicts_ball: bool) -> Self {
        if predicts_ball { self } else { Self { velocity: [0.0; 2], ..self } }
    }

    /// The ball `wait_s` later `[s]`, if nothing touches it.
    #[must_use]
    pub fn after(self, wait_s: f64) -> Self {
        let time = effective_time(wait_s, self.decay);
        let kept = 1.0 - self.decay * time;
        let place = [0, 1].map(|k| self.place[k] + time * self.velocity[k]);
        Self { place, velocity: self.velocity.map(|v| kept * v), ..self }
    }

    /// Where it will be when it is met in a motion that has begun at `frame` `[m]`.
    pub fn at_strike(&self, facts: &MotionFacts, frame: usize, dt_s: f64) -> [f64; 2] {
        let wait = facts.contact_frame.saturating_sub(frame) as f64 * dt_s;
        self.after(wait).place
    }
}

/// The motion whose own place is nearest to where the ball (in the start frame) will be when that motion strikes; the
/// first of equals. `dt_s` is the time between two frames.
///
/// # Panics
/// If there are no motions.
pub fn motion_for(motions: &[MotionFacts], ball: &RollingBall, dt_s: f64) -> usize {
    nearest(motions, |facts| ball.at_strike(facts, 0, dt_s))
}

fn nearest(motions: &[MotionFacts], place: impl Fn(&MotionFacts) -> [f64; 2]) -> usize {
    let distance = |facts: &MotionFacts| {
        let ([x, y], [to_x, to_y]) = (own_place(facts), place(facts));
        (x - to_x).hypot(y - to_y)
    };
    (1..motions.len())
        .fold(0, |best, i| if distance(&motions[i]) < distance(&motions[best]) { i } else { best })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facts() -> MotionFacts {
        MotionFacts {
            name: "m".into(),
            frames: 100,
            kick_foot: 1,
            strike_frame: 70,
            contact_frame: 70,
            strike_speed: 5.0,
            start_xy: [1.0, 2.0],
            base_xy: [1.1, 2.0],
            heading: -core::f64::consts::FRAC_PI_2,
            displacement: [0.0, -0.8],
        }
    }

    #[test]
    fn a_motions_own_place_is_where_its_robot_ends_seen_from_where_it_starts() {
        let facts = MotionFacts {
            name: "kick".into(),
            frames: 2,
            kick_foot: 0,
            strike_frame: 1,
            contact_frame: 1,
            strike_speed: 0.0,
            start_xy: [3.0, 4.0],
            base_xy: [3.0, 4.0],
            heading: std::f64::consts::FRAC_PI_2,
            displacement: [-0.5, 2.0],
        };
        let [x, y] = own_place(&facts);
        assert!((x - 2.0).abs() < 1e-12 && (y - 0.5).abs() < 1e-12, "{x} {y}");
    }

    #[test]
    fn a_rolling_ball_belongs_to_the_motion_that_meets_it() {
        // Both at 0.02 s a frame: 1.4 s to the first one's strike, 0.5 s to the second one's.
        let early = MotionFacts { displacement: [0.6, -0.8], contact_frame: 25, ..facts() };
        let motions = [facts(), early];
        // Ahead is -y, left is +x: the second motion ends 0.6 m to the left of the first one.
        let ball = |velocity, decay| RollingBall { place: [0.8, 0.2], velocity, decay };
        assert_eq!(motion_for(&motions, &ball([0.0; 2], 0.0), 0.02), 0);
        assert_eq!(motion_for(&motions, &ball([0.0, 0.3], 0.0), 0.02), 1);
        // 0.2 + 0.3 * 1.4 = 0.62 at the first one's strike, 0.35 at the second one's.
        assert!((ball([0.0, 0.3], 0.0).at_strike(&motions[0], 0, 0.02)[1] - 0.62).abs() < 1e-12);
        assert!((ball([0.0, 0.3], 0.0).at_strike(&motions[0], 60, 0.02)[1] - 0.26).abs() < 1e-12);
        // One that stops at once stays where it is.
        assert_eq!(motion_for(&motions, &ball([0.0, 0.3], 50.0), 0.02), 0);
    }

    #[test]
    fn a_policy_that_does_not_predict_chooses_by_the_ball_s_place() {
        let ball = RollingBall { place: [0.8, 0.2], velocity: [0.0, 0.3], decay: 0.5 };
        assert_eq!(ball.as_chosen_by(true), ball);
        assert_eq!(ball.as_chosen_by(false), RollingBall { velocity: [0.0; 2], ..ball });
    }

    #[test]
    fn the_start_frame_looks_along_the_heading() {
        let [x, y] = from_start_frame(&facts(), [1.0, 0.5]);
        assert!((x - 1.5).abs() < 1e-12 && (y - 1.0).abs() < 1e-12, "{x} {y}");
    }
}
