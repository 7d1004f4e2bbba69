//! How a run went, thinned: what a chart needs.

use crate::runtime::{State, Status};

/// Time between two points `[us]`.
const EVERY_US: u64 = 50_000;

/// What a plot of a run needs: the runtime's status, thinned.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Course {
    begin_us: Option<u64>,
    due_us: u64,
    points: Vec<CoursePoint>,
}

/// A moment of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CoursePoint {
    /// Since the first moment `[s]`.
    pub time_s: f64,
    /// The runtime's state.
    pub state: State,
    /// The pelvis from upright `[rad]`.
    pub tilt_rad: f64,
    /// Kicks that have begun.
    pub kicks: usize,
    /// The pelvis by odometry (x, y) `[m]`.
    pub at: Option<[f64; 2]>,
    /// The estimated center of the goal, in odometry's frame (x, y) `[m]`.
    pub goal: Option<[f64; 2]>,
    /// Estimated place of the ball, ahead of the torso and to its left `[m]`, and the age of what was seen of it `[s]`.
    pub ball: Option<([f64; 2], f64)>,
}

impl Course {
    /// The moments, in order of time.
    pub fn points(&self) -> &[CoursePoint] {
        &self.points
    }

    /// True if the moment of this time belongs in the plot.
    pub(super) fn due(&mut self, now_us: u64) -> bool {
        let due = self.begin_us.is_none() || now_us >= self.due_us;
        if due {
            self.due_us = now_us + EVERY_US;
        }
        due
    }

    /// Takes in a moment.
    pub(super) fn add(&mut self, status: &Status) {
        let begin_us = *self.begin_us.get_or_insert(status.at_us);
        self.points.push(CoursePoint {
            time_s: status.at_us.saturating_sub(begin_us) as f64 * 1e-6,
            state: status.state,
            tilt_rad: status.tilt_rad,
            kicks: status.kicks,
            at: status.odometry_m.map(|[x, y, _]| [x, y]),
            goal: status.goal_m,
            ball: status.ball_m.map(|ball| (ball, status.ages_s[2])),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_due_every_twentieth_of_a_second() {
        let mut course = Course { begin_us: Some(0), ..Course::default() };
        let second = (0..500).filter(|step| course.due(7_000_000 + 2_000 * step));
        assert_eq!(second.count(), 20);
    }
}
