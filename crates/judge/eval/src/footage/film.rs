//! Films of trials.

use paid_plot::{Film, Pose};
use paid_task::EnvSample;

use crate::episodes::{Ending, Observer};
use crate::metrics::shooting::Goal;

/// What a sample shows.
pub fn pose_of(sample: &EnvSample) -> Pose {
    Pose {
        step: sample.step,
        pos: sample.bodies.iter().map(|b| b.pos).collect(),
        rot: sample.bodies.iter().map(|b| b.rot).collect(),
        ball: sample.ball_pos,
        goal: sample.goal_pos,
        heading: sample.heading,
        kicked: sample.kick.is_some(),
    }
}

/// Base and ball after every step, past the goal plane (negative in front of it) and left of the goal's center `[m]`.
pub fn film_path(film: &Film) -> Vec<[[f64; 2]; 2]> {
    let local = |p: &Pose| {
        let goal = Goal { center: [p.goal[0], p.goal[1]], heading: p.heading, half_width: 0.0 };
        let base = p.pos.first().copied().unwrap_or_default();
        [goal.local([base[0], base[1]]), goal.local([p.ball[0], p.ball[1]])]
    };
    film.poses.iter().map(local).collect()
}

impl Observer for Film {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        self.poses.push(pose_of(sample));
        ended.is_some()
    }
}
