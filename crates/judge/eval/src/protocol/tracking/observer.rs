//! Follows one run of one motion.

use std::sync::Arc;

use paid_motion::displacement_in_heading;
use paid_play::ReferenceLibrary;
use paid_task::EnvSample;

use super::RunScore;
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::metrics::shooting::fallen;
use crate::metrics::tracking::{
    BodyTrack, TrackingErrors, body_errors, displacement_share, peak_jerk, tracking_errors,
};

/// What one run did, compared with the motion.
pub(crate) struct Watch {
    library: Arc<ReferenceLibrary>,
    motion: usize,
    tracked: Vec<usize>,
    anchor: usize,
    foot: usize,
    nominal_height_m: f64,
    robot: BodyTrack,
    reference: BodyTrack,
    /// Anchor: heading axis and position at the start, position now.
    first: Option<([f64; 2], [f64; 3])>,
    now: [f64; 3],
    robot_foot: FootRange,
    fell: bool,
    ended: Option<Ending>,
    /// A fall ends the run.
    until_fall: bool,
    frames_seen: usize,
}

/// Extremes of a foot.
#[derive(Clone, Copy)]
struct FootRange {
    peak_speed: f64,
    low: f64,
    high: f64,
}

impl FootRange {
    fn new() -> Self {
        Self { peak_speed: 0.0, low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
    fn see(&mut self, height: f64, velocity: [f64; 3]) {
        let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        self.peak_speed = self.peak_speed.max(speed);
        self.low = self.low.min(height);
        self.high = self.high.max(height);
    }
    fn lift(&self) -> f64 {
        self.high - self.low
    }
}

impl Watch {
    pub(crate) fn new(setup: &EvalSetup, motion: usize, until_fall: bool) -> Self {
        let index = |name: &String| setup.robot.body_index(name);
        let tracked: Vec<usize> = setup.spec.tracked_bodies.iter().filter_map(index).collect();
        Self {
            library: Arc::clone(&setup.library),
            motion,
            robot: BodyTrack::new(tracked.len().max(1)),
            reference: BodyTrack::new(tracked.len().max(1)),
            tracked,
            anchor: index(&setup.spec.anchor_body).unwrap_or(0),
            foot: index(&setup.spec.feet[setup.library.facts()[motion].kick_foot]).unwrap_or(0),
            nominal_height_m: setup.spec.nominal_height_m,
            first: None,
            now: [0.0; 3],
            robot_foot: FootRange::new(),
            fell: false,
            ended: None,
            until_fall,
            frames_seen: 0,
        }
    }

    /// How far off the clip the bodies were; `None` if nothing was seen.
    pub(crate) fn errors(&self) -> Option<TrackingErrors> {
        tracking_errors(&self.robot, &self.reference)
    }

    /// The figures of the run.
    pub(super) fn score(&self, exact: bool) -> RunScore {
        let clip = &self.library.clips()[self.motion];
        let bodies = clip.body_pos.len() / clip.frames;
        let anchor = |t: usize| clip.body_pos[t * bodies + self.anchor];
        let wanted = displacement_in_heading(clip.body_quat[self.anchor], anchor(0), anchor(clip.frames - 1));
        let walked = self.first.map_or([0.0; 2], |(axis, from)| in_axis(axis, from, self.now));
        // The whole clip is the measure, also of a run that failed before the kick.
        let mut reference_foot = FootRange::new();
        for t in 0..clip.frames {
            let row = t * bodies + self.foot;
            reference_foot.see(clip.body_pos[row][2], clip.body_com_vel[row]);
        }
        let ratio = |robot: f64, reference: f64| if reference > 1e-9 { robot / reference } else { 1.0 };
        RunScore {
            motion: self.motion,
            exact,
            completed: self.ended == Some(Ending::Over) && !(self.until_fall && self.fell),
            fell: self.fell,
            frames: self.frames_seen,
            errors: self.errors().unwrap_or_default(),
            body_errors_mm: body_errors(&self.robot, &self.reference),
            jerk: peak_jerk(&self.robot),
            reference_jerk: peak_jerk(&self.reference),
            displacement: walked,
            displacement_share: displacement_share(walked, wanted),
            foot_speed: self.robot_foot.peak_speed,
            foot_speed_share: ratio(self.robot_foot.peak_speed, reference_foot.peak_speed),
            lift_m: self.robot_foot.lift(),
            lift_share: ratio(self.robot_foot.lift(), reference_foot.lift()),
        }
    }
}

/// `to - from` with x along `axis` (unit, horizontal) and y to its left.
fn in_axis(axis: [f64; 2], from: [f64; 3], to: [f64; 3]) -> [f64; 2] {
    let (dx, dy) = (to[0] - from[0], to[1] - from[1]);
    [axis[0] * dx + axis[1] * dy, axis[0] * dy - axis[1] * dx]
}

impl Observer for Watch {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        let clip = &self.library.clips()[self.motion];
        let bodies = clip.body_pos.len() / clip.frames;
        let row = sample.frame.min(clip.frames - 1) * bodies;
        self.robot.push(self.tracked.iter().map(|&b| sample.bodies[b].pos));
        self.reference.push(self.tracked.iter().map(|&b| clip.body_pos[row + b]));

        let foot = &sample.bodies[self.foot];
        self.robot_foot.see(foot.pos[2], foot.com_vel);

        let anchor = &sample.bodies[self.anchor];
        if self.first.is_none() {
            let axis = [anchor.rot[0][0], anchor.rot[1][0]];
            let norm = axis[0].hypot(axis[1]).max(1e-9);
            self.first = Some(([axis[0] / norm, axis[1] / norm], anchor.pos));
        }
        self.now = anchor.pos;
        let base = &sample.bodies[0];
        self.fell |= fallen(base.pos[2] - sample.ground_m, base.rot[2][2], self.nominal_height_m);
        self.ended = self.ended.or(ended);
        self.frames_seen += 1;
        ended.is_some() || (self.until_fall && self.fell)
    }
}
