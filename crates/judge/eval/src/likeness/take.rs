//! One kick of a person or of a policy, and what can be measured of it.

use paid_lanes::{Mat3, Quat};
use paid_play::{MotionFacts, ReferenceClip};
use paid_robot::{RobotModel, RobotSpec};
use paid_task::EnvSample;

use crate::metrics::tracking::{BodyTrack, peak_jerk};

/// The swing is evaluated from this long before the strike to this long after it `[s]`.
const SWING_S: [f64; 2] = [0.6, 0.4];
/// The same for the path of the foot `[s]`.
const PATH_S: [f64; 2] = [0.4, 0.2];

/// Model indices of the bodies that kicks are compared by.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    feet: [usize; 2],
    hands: Vec<usize>,
    tracked: Vec<usize>,
    bodies: usize,
}

impl Parts {
    /// The feet, the other end effectors as hands, and the tracked bodies of a robot.
    pub(super) fn of(robot: &RobotModel, spec: &RobotSpec) -> Self {
        let index = |name: &String| robot.body_index(name);
        let others = spec.end_effectors.iter().filter(|name| !spec.feet.contains(name));
        Self {
            feet: spec.feet.each_ref().map(|name| index(name).unwrap_or(0)),
            hands: others.filter_map(index).collect(),
            tracked: spec.tracked_bodies.iter().filter_map(index).collect(),
            bodies: robot.bodies.len(),
        }
    }
}

/// Where everything was, frame after frame, at the control rate.
#[derive(Clone, Debug)]
pub(super) struct Take {
    dt_s: f64,
    joints: usize,
    bodies: usize,
    /// `[T, J]` `[rad]`.
    joint_pos: Vec<f64>,
    /// `[T, B]`, world `[m]`.
    body_pos: Vec<[f64; 3]>,
    /// Of the base `[T]` `[rad]`.
    heading: Vec<f64>,
    /// Frame in which a foot meets the ball, and which foot: 0 left, 1 right.
    pub(super) strike: Option<(usize, usize)>,
    /// Whether there was a ball to meet. A clip has none: its strike is where it is stated or its foot is fastest.
    pub(super) ball: bool,
}

/// How a kick swings. All of it is seen from the base, whose heading is ahead.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Swing {
    /// The farthest that the kicking foot is behind the base before the strike `[m]`.
    pub back_swing_m: f64,
    /// How far the hand that moves more goes ahead and back `[m]`.
    pub hand_swing_m: f64,
    /// How far the base turns `[deg]`.
    pub hip_turn_deg: f64,
}

impl Take {
    /// A take without frames.
    pub(super) fn new(parts: &Parts, joints: usize, dt_s: f64) -> Self {
        Self {
            dt_s,
            joints,
            bodies: parts.bodies,
            joint_pos: Vec::new(),
            body_pos: Vec::new(),
            heading: Vec::new(),
            strike: None,
            ball: true,
        }
    }

    /// A clip.
    pub(super) fn of_clip(clip: &ReferenceClip, facts: &MotionFacts) -> Self {
        let bodies = clip.body_pos.len() / clip.frames;
        let heading = |t: usize| Quat(clip.body_quat[t * bodies]).to_mat().yaw();
        Self {
            dt_s: 1.0 / clip.fps,
            joints: clip.joint_pos.len() / clip.frames,
            bodies,
            joint_pos: clip.joint_pos.clone(),
            body_pos: clip.body_pos.clone(),
            heading: (0..clip.frames).map(heading).collect(),
            strike: Some((facts.strike_frame, facts.kick_foot)),
            ball: false,
        }
    }

    /// Appends what a simulation shows.
    pub(super) fn push(&mut self, sample: &EnvSample) {
        self.joint_pos.extend_from_slice(&sample.joint_pos);
        self.body_pos.extend(sample.bodies.iter().map(|body| body.pos));
        self.heading.push(Mat3(sample.bodies[0].rot).yaw());
    }

    pub(super) fn frames(&self) -> usize {
        self.heading.len()
    }

    pub(super) fn joints(&self, t: usize) -> &[f64] {
        &self.joint_pos[t * self.joints..][..self.joints]
    }

    /// Time-averaged peak link jerk `[m/frame^3]`, as in the paper's AUJ ([`peak_jerk`]).
    pub(super) fn jerk(&self, parts: &Parts) -> f64 {
        let mut track = BodyTrack::new(parts.tracked.len().max(1));
        for t in 0..self.frames() {
            track.push(parts.tracked.iter().map(|&b| self.body_pos[t * self.bodies + b]));
        }
        peak_jerk(&track)
    }

    /// A body's place seen from `origin` with the heading `heading` ahead `[m]`.
    fn seen(&self, t: usize, body: usize, origin: [f64; 3], heading: f64) -> [f64; 3] {
        let p = self.body_pos[t * self.bodies + body];
        let [dx, dy, dz] = [0, 1, 2].map(|k| p[k] - origin[k]);
        let (s, c) = heading.sin_cos();
        [c * dx + s * dy, c * dy - s * dx, dz]
    }

    /// A body's way ahead of the base in a frame `[m]`.
    fn ahead(&self, t: usize, body: usize) -> f64 {
        self.seen(t, body, self.body_pos[t * self.bodies], self.heading[t])[0]
    }

    /// Frames from `before` the strike to `after` it `[s]`, as far as the take goes.
    fn around(&self, strike: usize, [before, after]: [f64; 2]) -> core::ops::RangeInclusive<usize> {
        let frames = |s: f64| (s / self.dt_s).round() as usize;
        let last = self.frames().saturating_sub(1);
        strike.saturating_sub(frames(before))..=(strike + frames(after)).min(last)
    }

    /// How the kick swings; `None` without a strike.
    pub(super) fn swing(&self, parts: &Parts) -> Option<Swing> {
        let (strike, foot) = self.strike.filter(|(strike, _)| *strike < self.frames())?;
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (mut lo, mut hi) = (f64::INFINITY, f64::NEG_INFINITY);
            values.for_each(|x| (lo, hi) = (lo.min(x), hi.max(x)));
            hi - lo
        };
        let window = self.around(strike, SWING_S);
        let before = *window.start()..=strike;
        let mut turned = 0.0;
        let mut turns = window.clone().map(|t| {
            let change = self.heading[t] - self.heading[t.saturating_sub(1).max(*window.start())];
            turned += change.sin().atan2(change.cos());
            turned
        });
        Some(Swing {
            back_swing_m: before.map(|t| -self.ahead(t, parts.feet[foot])).fold(f64::NEG_INFINITY, f64::max),
            hand_swing_m: parts
                .hands
                .iter()
                .map(|&hand| range(&mut window.clone().map(|t| self.ahead(t, hand))))
                .fold(0.0, f64::max),
            hip_turn_deg: range(&mut turns).to_degrees(),
        })
    }

    /// Path of the kicking foot around the strike, seen from where the base is at the strike: by the frame's distance from the strike
    /// plus the frames that are looked at before it; `None` where the take has no frame.
    pub(super) fn foot_path(&self, parts: &Parts) -> Option<(usize, Vec<Option<[f64; 3]>>)> {
        let (strike, foot) = self.strike.filter(|(strike, _)| *strike < self.frames())?;
        let [before, after] = PATH_S.map(|s| (s / self.dt_s).round() as usize);
        let origin = self.body_pos[strike * self.bodies];
        let path = (0..=before + after).map(|k| {
            let t = (strike + k).checked_sub(before).filter(|t| *t < self.frames())?;
            Some(self.seen(t, parts.feet[foot], origin, self.heading[strike]))
        });
        Some((foot, path.collect()))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// A base, a left and a right foot, and one hand; the base is the only tracked body.
    pub fn parts() -> Parts {
        Parts { feet: [1, 2], hands: vec![3], tracked: vec![0], bodies: 4 }
    }

    /// 100 frames a second. The base turns from 90 to 120 degrees in 30 frames and stands still. Seen from it, the right foot goes from
    /// 0.3 m behind to 0.2 m ahead in 50 frames, where it strikes, and the hand from 0.1 ahead to 0.1 behind in the same time.
    pub fn take() -> Take {
        let frames = 60;
        let mut take = Take::new(&parts(), 1, 0.01);
        for t in 0..frames {
            let share = f64::from(t).min(50.0) / 50.0;
            let heading = (90.0 + f64::from(t).min(30.0)).to_radians();
            let (s, c) = heading.sin_cos();
            let base = [1.0, 2.0, 0.8];
            let place = |ahead: f64, left: f64, z: f64| {
                [base[0] + c * ahead - s * left, base[1] + s * ahead + c * left, z]
            };
            let foot = -0.3 + 0.5 * share;
            take.body_pos.extend([
                base,
                place(0.0, 0.1, 0.05),
                place(foot, -0.1, 0.1),
                place(0.1 - 0.2 * share, 0.3, 0.9),
            ]);
            take.joint_pos.push(share);
            take.heading.push(heading);
        }
        take.strike = Some((50, 1));
        take
    }

    impl Take {
        pub fn shift_joints(&mut self, by: f64) {
            self.joint_pos.iter_mut().for_each(|q| *q += by);
        }
        pub fn shift_bodies(&mut self, body: usize, by: [f64; 3]) {
            for p in self.body_pos.iter_mut().skip(body).step_by(self.bodies) {
                *p = [0, 1, 2].map(|k| p[k] + by[k]);
            }
        }
    }

    #[test]
    fn a_swing_is_seen_from_the_base() {
        let swing = take().swing(&parts()).expect("a strike");
        assert!((swing.back_swing_m - 0.3).abs() < 1e-9, "{swing:?}");
        assert!((swing.hand_swing_m - 0.2).abs() < 1e-9, "{swing:?}");
        assert!((swing.hip_turn_deg - 30.0).abs() < 1e-9, "{swing:?}");
        assert_eq!(Take { strike: None, ..take() }.swing(&parts()), None);
    }

    #[test]
    fn a_turn_across_half_a_circle_stays_small() {
        let mut over = take();
        over.heading.iter_mut().for_each(|h| *h += 80_f64.to_radians());
        over.heading.iter_mut().for_each(|h| *h = h.sin().atan2(h.cos()));
        let swing = over.swing(&parts()).expect("a strike");
        assert!((swing.hip_turn_deg - 30.0).abs() < 1e-9, "{swing:?}");
    }

    #[test]
    fn a_foots_path_is_seen_from_the_base_at_the_strike() {
        let (foot, path) = take().foot_path(&parts()).expect("a strike");
        assert_eq!((foot, path.len()), (1, 61));
        let [x, y, z] = path[40].expect("the strike");
        assert!((x - 0.2).abs() < 1e-9 && (y + 0.1).abs() < 1e-9 && (z + 0.7).abs() < 1e-9);
        // 0.4 s before the strike the base looked 20 degrees farther to the right.
        let [x, y, _] = path[0].expect("frame 10");
        let (s, c) = (-20_f64).to_radians().sin_cos();
        let (ahead, left) = (-0.2, -0.1);
        assert!((x - (c * ahead - s * left)).abs() < 1e-9 && (y - (s * ahead + c * left)).abs() < 1e-9);
        assert_eq!(path[50], None, "the take ends 9 frames after the strike");
    }
}
