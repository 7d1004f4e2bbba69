//! Where the ball is: from onboard perception, or from the tracker here on virtual senses' images.

use paid_play::RollingBall;
use paid_track::{BallEstimate, BallTracker, Belief, Measurement, Rolling, TrackerPreset};

use super::place::Place;
use crate::message::{BallDetection, EyesReport};
use crate::player::Player;

/// An image that shows the ball farther from its estimate shows another ball, or the same one after it was moved `[m]`.
const SAME_M: f64 = 0.25;
/// The tracker stays this far behind the present `[s]`: later images are not used.
const HORIZON_S: f64 = 0.15;
/// Images that may wait for the next policy step.
const WAITING: usize = 64;

/// The ball as the robot believes it, in odometry's frame.
#[derive(Clone, Debug)]
pub(super) struct Ball {
    tracker: BallTracker<f64>,
    preset: TrackerPreset,
    /// Rate at which a rolling ball slows `[1/s]`.
    pub decay: f64,
    /// Its radius `[m]`.
    pub radius: f64,
    now_us: u64,
    /// Height of the floor in odometry's frame `[m]`: 0 for virtual senses, whose frame begins on it.
    floor: f64,
    /// Perception's estimate, and when it held `[us]`.
    report: Option<(u64, EyesReport)>,
    pictures: Vec<BallDetection>,
    /// Images in a row that showed the ball at its estimate.
    looks: u32,
}

impl Ball {
    pub fn new(player: &Player) -> Self {
        Self {
            tracker: BallTracker::new(),
            preset: player.play.eyes.tracker.clone(),
            decay: player.play.ball_decay(),
            radius: player.play.ball_params.radius_m,
            now_us: 0,
            floor: 0.0,
            report: None,
            pictures: Vec::with_capacity(WAITING),
            looks: 0,
        }
    }

    /// From here on it is this late `[us]`.
    pub fn now(&mut self, now_us: u64) {
        self.now_us = now_us;
    }

    /// Height of the ball's center when it lies, odometry's frame `[m]`.
    pub fn height(&self) -> f64 {
        self.floor + self.radius
    }

    /// Takes in perception's estimate in its odometry frame `frame`.
    pub fn report(&mut self, now_us: u64, report: &EyesReport, frame: Option<u32>) {
        let finite = report.ball.is_none_or(|ball| {
            let numbers = ball.position.iter().chain(&ball.velocity).chain(&ball.covariance);
            numbers.chain([&ball.rest, &ball.age_s]).all(|x| x.is_finite())
        });
        if finite && frame == Some(report.frame) {
            // Without the floor it is unknown how far below the robot the ball is.
            let floor = report.floor_m.filter(|floor| floor.is_finite());
            self.floor = floor.unwrap_or(self.floor);
            let report = &EyesReport { ball: report.ball.filter(|_| floor.is_some()), ..*report };
            self.report = Some((now_us.saturating_sub(report.age_us), *report));
        }
    }

    /// Forgets the estimates of onboard perception.
    pub fn forget_report(&mut self) {
        self.report = None;
    }

    /// Takes in an image, to be fused at the next policy step.
    pub fn sighting(&mut self, sighting: BallDetection) {
        let finite = sighting.ball.is_none_or(|ball| ball.iter().all(|x| x.is_finite()));
        if finite && sighting.deviation_m > 0.0 && self.pictures.len() < WAITING {
            self.pictures.push(sighting);
        }
    }

    /// A policy step of the tracker; `to_strike_s` is the time until the motion strikes `[s]`, infinite before a kick.
    pub fn advance(&mut self, now_us: u64, dt_s: f64, to_strike_s: f64, place: &Place) {
        let rolling = Rolling { decay: self.decay, to_strike_s };
        self.tracker.advance(dt_s, HORIZON_S, &rolling, &self.preset);
        self.pictures.sort_by_key(|picture| picture.captured_us);
        for picture in self.pictures.drain(..) {
            let (Some(torso), Some(ball)) = (place.torso_at(picture.captured_us), picture.ball) else {
                continue;
            };
            let [x, y, _] = torso.point(ball);
            let belief = self.tracker.belief(&rolling, &self.preset);
            let [bx, by] = belief.ball.position;
            let same = belief.known && (x - bx).hypot(y - by) < SAME_M;
            self.looks = if same { self.looks.saturating_add(1) } else { 0 };
            let picture = Measurement {
                position: [x, y],
                variance: picture.deviation_m * picture.deviation_m,
                age_s: now_us.saturating_sub(picture.captured_us) as f64 * 1e-6,
                seen: true,
            };
            self.tracker.fuse(&picture, &rolling, &self.preset);
        }
    }

    /// Images in a row that showed the ball at its estimate.
    pub fn looks(&self) -> u32 {
        self.report.map_or(self.looks, |(_, report)| report.ball.map_or(0, |ball| ball.looks))
    }

    /// The estimate: of onboard perception, continued since its report, or of the tracker here.
    pub fn belief(&self, to_strike_s: f64) -> Belief<f64> {
        let ball = self.report.and_then(|(at_us, report)| report.ball.map(|ball| (at_us, ball)));
        let Some((at_us, ball)) = ball else {
            return self.tracker.belief(&Rolling { decay: self.decay, to_strike_s }, &self.preset);
        };
        let since_s = self.now_us.saturating_sub(at_us) as f64 * 1e-6;
        let then = RollingBall { place: ball.position, velocity: ball.velocity, decay: self.decay };
        let now = then.after(since_s);
        Belief {
            ball: BallEstimate { position: now.place, velocity: now.velocity, covariance: ball.covariance },
            rest: ball.rest,
            age_s: ball.age_s + since_s,
            known: !ball.lost,
        }
    }
}
