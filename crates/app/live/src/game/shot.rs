//! One shot from its ball's appearance to its verdict.

use paid_eval::metrics::shooting::Goal;
use paid_task::EnvSample;

use super::GOAL_HEIGHT_M;
use crate::board::{Outcome, Shot};

/// A ball slower than this has come to rest `[m/s]`.
const AT_REST_M_S: f64 = 0.06;
/// Time after the clip's end at which a ball that was not touched counts as missed `[s]`.
const PATIENCE_S: f64 = 0.6;
/// Time after the clip's end at which a touched ball without an outcome counts as short `[s]`.
const LONGEST_S: f64 = 5.0;

/// The shot that is played.
#[derive(Clone, Debug)]
pub(super) struct Playing {
    /// Ball place in the robot's axes `[m]`.
    place: [f64; 2],
    rolling: bool,
    clip: String,
    /// The fastest that the ball was after the touch `[m/s]`.
    fastest: f64,
    /// Control steps since the clip's end.
    over: u32,
}

/// Whether it is over.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Verdict {
    Open,
    Decided(Shot),
}

impl Playing {
    pub(super) fn new(place: [f64; 2], rolling: bool, clip: String) -> Self {
        Self { place, rolling, clip, fastest: 0.0, over: 0 }
    }

    fn shot(&self, outcome: Outcome, speed_m_s: f64, lateral_m: Option<f64>, miss_m: Option<f64>) -> Verdict {
        Verdict::Decided(Shot {
            number: 0,
            outcome,
            speed_m_s,
            lateral_m,
            miss_m,
            ball: self.place,
            rolling: self.rolling,
            clip: self.clip.clone(),
            engine: "",
            surface: "",
        })
    }

    /// Follows the ball from `before` to `ball` (pitch axes) over a control step.
    pub(super) fn follow(
        &mut self,
        goal: &Goal,
        sample: &EnvSample,
        before: [f64; 3],
        ball: [f64; 3],
        speed: f64,
        dt_s: f64,
    ) -> Verdict {
        let touched = sample.kick.is_some();
        if touched {
            self.fastest = self.fastest.max(speed);
            if let Some(crossing) = goal.crossing([before[0], before[1]], [ball[0], ball[1]]) {
                let height = before[2] + (ball[2] - before[2]) * crossing.share;
                let (aside, above) = (crossing.lateral.abs() - goal.half_width, height - GOAL_HEIGHT_M);
                let outcome = match (crossing.inside, above <= 0.0) {
                    (true, true) => Outcome::Goal,
                    (false, _) => Outcome::Wide,
                    (true, false) => Outcome::Over,
                };
                let miss = aside.max(0.0).hypot(above.max(0.0));
                return self.shot(outcome, speed, Some(crossing.lateral), Some(miss));
            }
        }
        if !sample.motion_ended {
            return Verdict::Open;
        }
        self.over += 1;
        let waited_s = f64::from(self.over) * dt_s;
        if touched && (speed < AT_REST_M_S || waited_s > LONGEST_S) {
            return self.shot(Outcome::Short, self.fastest, None, None);
        }
        if !touched && waited_s > PATIENCE_S {
            return self.shot(Outcome::NoContact, speed, None, None);
        }
        Verdict::Open
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use paid_task::KickEvent;

    const GOAL: Goal = Goal { center: [5.0, 0.0], heading: 0.0, half_width: 1.0 };

    fn sample(touched: bool, motion_ended: bool) -> EnvSample {
        let kick = KickEvent {
            step: 1,
            foot: 1,
            correct: true,
            body: None,
            foot_vel: [0.0; 3],
            ball_vel_after: None,
        };
        EnvSample {
            motion: 0,
            frame: 0,
            step: 0,
            motion_ended,
            bodies: Vec::new(),
            joint_pos: Vec::new(),
            joint_target: Vec::new(),
            joint_vel: Vec::new(),
            joint_torque: Vec::new(),
            contact_force: Vec::new(),
            ground_m: 0.0,
            ball_pos: [0.0; 3],
            ball_vel: [0.0; 3],
            ball_force: [0.0; 3],
            goal_pos: [0.0; 3],
            reference_anchor: ([0.0; 2], 0.0),
            heading: 0.0,
            kick: touched.then_some(kick),
            rewards: Vec::new(),
        }
    }

    fn decided(verdict: Verdict) -> Shot {
        match verdict {
            Verdict::Decided(shot) => shot,
            Verdict::Open => panic!("still open"),
        }
    }

    fn playing() -> Playing {
        Playing::new([1.0, 0.0], false, "kick".into())
    }

    #[test]
    fn a_ball_through_the_mouth_counts_once_a_foot_has_touched_it() {
        let (a, b) = ([4.9, 0.3, 0.1], [5.1, 0.5, 0.1]);
        assert_eq!(playing().follow(&GOAL, &sample(false, false), a, b, 5.0, 0.02), Verdict::Open);
        let shot = decided(playing().follow(&GOAL, &sample(true, false), a, b, 5.0, 0.02));
        assert_eq!((shot.outcome, shot.speed_m_s, shot.miss_m), (Outcome::Goal, 5.0, Some(0.0)));
        assert!((shot.lateral_m.expect("crossed") - 0.4).abs() < 1e-12);
    }

    #[test]
    fn wide_is_measured_from_the_post_and_over_from_the_bar() {
        let touched = sample(true, false);
        let wide = decided(playing().follow(&GOAL, &touched, [4.9, 1.3, 0.1], [5.1, 1.3, 0.1], 5.0, 0.02));
        assert_eq!(wide.outcome, Outcome::Wide);
        assert!((wide.miss_m.expect("crossed") - 0.3).abs() < 1e-12);
        let over = decided(playing().follow(&GOAL, &touched, [4.9, 0.0, 1.1], [5.1, 0.0, 1.3], 5.0, 0.02));
        assert_eq!(over.outcome, Outcome::Over);
        assert!((over.miss_m.expect("crossed") - 0.2).abs() < 1e-12);
    }

    #[test]
    fn a_ball_that_rests_is_short_and_one_that_nobody_met_is_told_apart() {
        let at = [2.0, 0.0, 0.11];
        let short = decided(playing().follow(&GOAL, &sample(true, true), at, at, 0.01, 0.02));
        assert_eq!((short.outcome, short.miss_m), (Outcome::Short, None));
        let mut playing = playing();
        let missed = sample(false, true);
        // 0.6 s are 30 steps.
        assert!((0..30).all(|_| playing.follow(&GOAL, &missed, at, at, 0.0, 0.02) == Verdict::Open));
        let shot = decided(playing.follow(&GOAL, &missed, at, at, 0.0, 0.02));
        assert_eq!(shot.outcome, Outcome::NoContact);
    }
}
