//! What the robot sees and estimates during a kick, compared with the truth.

use cpu_time::ThreadTime;
use paid_track::Pose;
use paid_world::{Arrived, Believed, Message, OdometryState, Recorder, Sight, seconds};

use super::judge::{EyesOutcome, SightingError};
use super::senses::{Moment, Senses, eyes_error};
use super::stage::STEP_NS;
use crate::EvalError;

/// Physics steps of a control step while it stands or goes there.
pub(super) const SUBSTEPS: u64 = 10;
/// A detection this far from the ball is of something else `[m]`.
const OF_BALL_M: f64 = 0.3;
/// If less of the ball is in the image, a detection is not expected.
pub(super) const LEAST_SHOWN: f64 = 0.25;

/// The course of a kick, in the frame of the trial's start `[m]`.
#[derive(Clone, Debug, Default)]
pub struct KickLog {
    /// Every control step.
    pub steps: Vec<LoggedStep>,
    /// Detections: time of capture `[s]`, position, and whether it was accepted as the ball.
    pub finds: Vec<(f64, [f64; 2], bool)>,
    /// When the motion began and when its foot was to strike `[s]`.
    pub start_s: f64,
    /// See `start_s`; `None` without a kick.
    pub strike_s: Option<f64>,
}

/// A control step of a kick.
#[derive(Clone, Copy, Debug)]
pub struct LoggedStep {
    /// Time `[s]`.
    pub time_s: f64,
    /// The ball.
    pub truth: [f64; 2],
    /// Where it is believed, with the standard deviation `[m]` and the state.
    pub believed: Option<([f64; 2], f64, &'static str)>,
}

/// The truth at a control step.
#[derive(Clone, Copy)]
pub(super) struct Truth {
    pub torso: Pose,
    pub ball: [f64; 3],
    pub ball_vel: [f64; 3],
}

/// A trial that is under way.
pub(super) struct Kick {
    pub senses: Senses,
    pub sight: Sight,
    pub recorder: Option<Recorder>,
    pub truths: Vec<Truth>,
    pub eyes: EyesOutcome,
    pub log: KickLog,
    /// Start frame from odometry's, as it was when the motion was chosen.
    pub start_from_odometry: Option<Pose>,
    /// When odometry had its first pose `[ns]`: earlier images give none.
    pub placed_ns: Option<u64>,
    /// Odometry from the start frame at the capture of the last image of the ball.
    pub when_seen: Option<Pose>,
    pub begin: ThreadTime,
}

impl Kick {
    /// A control step of sensors and pipeline.
    pub fn step(&mut self, moment: &Moment, to_strike_s: f64, open: bool) -> Result<Believed, EvalError> {
        self.truths.push(Truth { torso: moment.torso, ball: moment.ball, ball_vel: moment.ball_vel });
        let begin = self.begin.elapsed().as_secs_f64();
        let mut arrived = self.senses.step(moment, open);
        let sensed = self.begin.elapsed().as_secs_f64();
        arrived.push(Arrived { at_ns: moment.at_ns, message: Message::Step { to_strike_s } });
        let mut believed = None;
        for message in &arrived {
            believed = self.sight.take(message).map_err(eyes_error)?.or(believed);
        }
        let now = self.begin.elapsed().as_secs_f64();
        self.eyes.sensors_cpu_s += sensed - begin;
        self.eyes.sight_cpu_s += now - sensed;
        let believed = believed.ok_or_else(|| eyes_error("a step without an answer"))?;
        if let Some(recorder) = &mut self.recorder {
            for message in &arrived {
                recorder.message(message).map_err(eyes_error)?;
            }
            recorder.believed(&believed).map_err(eyes_error)?;
        }
        self.judge_sightings();
        if believed.torso.is_some() {
            self.placed_ns.get_or_insert(moment.at_ns);
        }
        if !matches!(believed.odometry, OdometryState::Tracking | OdometryState::Waiting) {
            self.eyes.untracked_steps += 1;
        }
        let ball = believed.ball.map(|ball| {
            let b = ball.belief.ball;
            let place = self.in_start(&believed, b.position);
            (place, b.covariance[0].max(0.0).sqrt(), ball.state.name())
        });
        self.log.steps.push(LoggedStep {
            time_s: seconds(moment.at_ns),
            truth: [moment.ball[0], moment.ball[1]],
            believed: ball,
        });
        Ok(believed)
    }

    /// A robot that stands: the physics steps before `at_ns`.
    pub fn hold(&mut self, at_ns: u64, torso: &Pose) {
        let dt_ns = STEP_NS / SUBSTEPS;
        for k in (1..SUBSTEPS).rev().filter(|k| at_ns > k * dt_ns) {
            self.senses.torso(at_ns - k * dt_ns, torso);
        }
    }

    /// A place of odometry's frame in the start's, by the alignment of the start; before it by the present one.
    pub fn in_start(&self, believed: &Believed, [x, y]: [f64; 2]) -> [f64; 2] {
        let aligned = self.start_from_odometry.or_else(|| self.alignment(believed).map(|a| a.inverse()));
        aligned.map_or([x, y], |aligned| {
            let [x, y, _] = aligned.point([x, y, 0.0]);
            [x, y]
        })
    }

    /// Odometry from the start's frame, as of now.
    pub fn alignment(&self, believed: &Believed) -> Option<Pose> {
        let truth = self.truths.last()?;
        Some(believed.torso?.compose(&truth.torso.inverse()))
    }

    /// How far from its place the ball is believed, seen from the torso `[m]`.
    pub fn error(&self, believed: &Believed) -> Option<f64> {
        let (ball, truth) = (believed.ball?, self.truths.last()?);
        let [x, y] = ball.belief.ball.position;
        let [x, y, _] = self.alignment(believed)?.inverse_point([x, y, 0.0]);
        Some((x - truth.ball[0]).hypot(y - truth.ball[1]))
    }

    fn judge_sightings(&mut self) {
        for sighted in self.sight.take_sighted() {
            let index = (sighted.captured_ns / STEP_NS) as usize;
            let Some(truth) = self.truths.get(index).copied() else { continue };
            let Some(torso) = self.sight.torso(seconds(sighted.captured_ns)) else { continue };
            let alignment = torso.compose(&truth.torso.inverse());
            let place = alignment.inverse_point(sighted.position);
            if sighted.own {
                self.when_seen = Some(alignment);
            }
            let from = truth.torso.pos;
            let ray = [truth.ball[0] - from.x(), truth.ball[1] - from.y()];
            let distance_m = ray[0].hypot(ray[1]).max(1e-6);
            let (c, s) = (ray[0] / distance_m, ray[1] / distance_m);
            let off = [place[0] - truth.ball[0], place[1] - truth.ball[1]];
            let before = self.truths[index.saturating_sub(1)].torso.pos;
            let torso_vel = (from - before).scale(1.0 / seconds(STEP_NS));
            let speed_m_s = (truth.ball_vel[0] - torso_vel.x()).hypot(truth.ball_vel[1] - torso_vel.y());
            let showed = self.senses.showed.iter().find(|showed| showed.captured_ns == sighted.captured_ns);
            let of_ball = off[0].hypot(off[1]) < OF_BALL_M;
            if of_ball {
                let since = self.placed_ns.is_some_and(|since| sighted.captured_ns >= since);
                let asked = since && showed.is_some_and(|showed| showed.shown >= LEAST_SHOWN);
                self.eyes.found += usize::from(asked);
            } else {
                self.eyes.false_finds += 1;
            }
            self.eyes.sightings.push(SightingError {
                distance_m,
                speed_m_s,
                age_s: seconds(sighted.fused_ns - sighted.captured_ns),
                error_m: [c * off[0] + s * off[1], c * off[1] - s * off[0]],
                shown: showed.map_or(0.0, |showed| showed.shown),
                own: sighted.own,
            });
            let place = self.start_from_odometry.map_or([place[0], place[1]], |aligned| {
                let [x, y, _] = aligned.point(sighted.position);
                [x, y]
            });
            self.log.finds.push((seconds(sighted.captured_ns), place, sighted.own));
        }
    }

    /// Evaluates the estimate shortly before the strike.
    pub fn judge_strike(&mut self, believed: &Believed) {
        let Some(ball) = believed.ball else { return };
        self.eyes.strike_error_m = self.error(believed);
        self.eyes.strike_age_s = Some(ball.belief.age_s);
        self.eyes.strike_state = Some(ball.state.name());
        if let (Some(then), Some(now), Some(truth)) =
            (self.when_seen, self.alignment(believed), self.truths.last())
        {
            let moved = now.inverse_point(then.point(truth.ball));
            self.eyes.odometry_error_m = Some((moved[0] - truth.ball[0]).hypot(moved[1] - truth.ball[1]));
        }
    }
}
