//! Follows one match, and says when the next ball comes.

use paid_plot::Film;
use paid_task::{BelievedBall, EnvSample, EvalControl, InitialState, KickEvent, NextKick};

use super::draw::Draw;
use super::report::{KickOutcome, MatchOutcome};
use super::{Audience, MatchOptions, Spectacle};
use crate::EvalError;
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::footage::pose_of;
use crate::metrics::shooting::{Crossing, Goal, fallen};

/// A ball slower than this has come to rest `[m/s]`.
const AT_REST: f64 = 0.05;
/// Control steps between two frames of a film.
const FILM_EVERY: u32 = 4;

/// The kick that is being played.
struct Playing {
    next: NextKick,
    /// Control step at which its ball appeared.
    from: u32,
    /// The ball one control step ago.
    before: Option<[f64; 3]>,
    kick: Option<KickEvent>,
    crossing: Option<Crossing>,
    /// Control steps since the clip's end.
    over: u32,
    /// Of these, how many in a row the robot has stood still.
    still: u32,
    /// Sums over them of the base's speed `[m/s]` and of the joints' speed `[rad/s]`.
    speeds: [f64; 2],
}

impl Playing {
    fn new(next: NextKick, from: u32) -> Self {
        Self { next, from, before: None, kick: None, crossing: None, over: 0, still: 0, speeds: [0.0; 2] }
    }
}

/// A match.
pub(super) struct Player<'a> {
    setup: &'a EvalSetup,
    options: &'a MatchOptions,
    draw: Draw<'a>,
    anchor: usize,
    playing: Playing,
    kicks: Vec<KickOutcome>,
    pending: Option<NextKick>,
    audience: Audience<'a>,
    films: Vec<Film>,
    /// Of this moment, for a spectator: the ball's angular velocity, and the robot's estimate of the ball.
    beside: ([f64; 3], Option<BelievedBall>),
}

/// Speed of the base `[m/s]` and root mean square of the joints' speeds `[rad/s]`.
fn speeds(sample: &EnvSample) -> [f64; 2] {
    let square = |values: &[f64]| values.iter().map(|v| v * v).sum::<f64>();
    let joints = sample.joint_vel.len().max(1) as f64;
    [square(&sample.bodies[0].com_vel).sqrt(), (square(&sample.joint_vel) / joints).sqrt()]
}

/// `seconds` in control steps.
fn steps(setup: &EvalSetup, seconds: f64) -> u32 {
    (seconds / setup.preset.control_dt_s()).round() as u32
}

impl<'a> Player<'a> {
    pub(super) fn new(
        setup: &'a EvalSetup,
        options: &'a MatchOptions,
        draw: Draw<'a>,
        start: &InitialState,
        audience: Audience<'a>,
    ) -> Self {
        let first = NextKick {
            motion: start.motion,
            ball_xy: start.ball_xy.unwrap_or_default(),
            ball_velocity: start.ball_velocity,
            goal_xy: start.goal_xy.unwrap_or_default(),
            look: 0,
        };
        Self {
            setup,
            options,
            draw,
            anchor: setup.robot.body_index(&setup.spec.anchor_body).unwrap_or(0),
            playing: Playing::new(first, 0),
            kicks: Vec::new(),
            pending: None,
            audience,
            films: Vec::new(),
            beside: ([0.0; 3], None),
        }
    }

    /// Its result, and the films of its first kicks.
    pub(super) fn finish(self, number: usize) -> (MatchOutcome, Vec<Film>) {
        (MatchOutcome::new(number, self.kicks), self.films)
    }

    /// Ends the kick that is being played; `last`: and the match with it.
    fn end_kick(&mut self, sample: &EnvSample, fell: bool, last: bool) {
        let playing = &self.playing;
        let kick = playing.kick.as_ref();
        let feet = self.setup.spec.feet.each_ref().map(|name| self.setup.robot.body_index(name));
        let body = kick.and_then(|k| k.body);
        let anchor = &sample.bodies[self.anchor];
        let (place, heading) = sample.reference_anchor;
        let turn = anchor.rot[1][0].atan2(anchor.rot[0][0]) - heading;
        let seconds = f64::from(sample.step - playing.from) * self.setup.preset.control_dt_s();
        let outcome = KickOutcome {
            motion_name: self.setup.library.facts()[playing.next.motion].name.clone(),
            ball: playing.next.ball_xy,
            ball_velocity: playing.next.ball_velocity,
            goal_center: playing.next.goal_xy,
            contact: kick.is_some(),
            correct_foot: kick.is_some_and(|k| k.correct),
            foot_contact: body.is_some() && feet.contains(&body),
            goal: playing.crossing.is_some_and(|c| c.inside),
            lateral_m: playing.crossing.map(|c| c.lateral),
            seconds,
            still: playing.still >= steps(self.setup, self.options.still_s),
            held_speeds: playing.speeds.map(|sum| sum / f64::from(playing.over.max(1))),
            fell,
            drift_m: (!fell).then(|| (anchor.pos[0] - place[0]).hypot(anchor.pos[1] - place[1])),
            drift_rad: (!fell).then(|| turn.sin().atan2(turn.cos()).abs()),
        };
        if let Some(spectator) = self.audience.spectator {
            spectator.kicked(self.draw.number(), &outcome, last);
        }
        self.kicks.push(outcome);
    }

    fn show(&self, sample: &EnvSample) {
        if let Some(spectator) = self.audience.spectator {
            let (ball_spin, believed) = self.beside;
            spectator.see(&Spectacle { number: self.draw.number(), sample, ball_spin, believed });
        }
    }

    fn film(&mut self, sample: &EnvSample) {
        if self.kicks.len() >= self.audience.filmed || !sample.step.is_multiple_of(FILM_EVERY) {
            return;
        }
        if self.films.len() <= self.kicks.len() {
            self.films.push(Film::default());
        }
        if let Some(film) = self.films.last_mut() {
            film.poses.push(pose_of(sample));
        }
    }
}

impl Observer for Player<'_> {
    fn look_on(&mut self, world: &dyn EvalControl, env: usize) -> Result<(), EvalError> {
        if self.audience.spectator.is_some() {
            self.beside = (world.ball_spin(env)?, world.believed_ball(env)?);
        }
        Ok(())
    }

    fn observe(&mut self, sample: &EnvSample, _ended: Option<Ending>) -> bool {
        self.film(sample);
        self.show(sample);
        let base = &sample.bodies[0];
        if fallen(base.pos[2] - sample.ground_m, base.rot[2][2], self.setup.spec.nominal_height_m) {
            self.end_kick(sample, true, true);
            return true;
        }
        let (ball, [base_speed, joint_speed]) = (sample.ball_pos, speeds(sample));
        let still = base_speed < self.options.still_base_m_s && joint_speed < self.options.still_joint_rad_s;
        let playing = &mut self.playing;
        playing.kick.clone_from(&sample.kick);
        let goal = Goal {
            center: [sample.goal_pos[0], sample.goal_pos[1]],
            heading: sample.heading,
            half_width: self.options.goal_half_width_m,
        };
        // Only a kicked ball can score.
        if let (Some(before), Some(_), None) = (playing.before, &playing.kick, playing.crossing) {
            playing.crossing = goal.crossing([before[0], before[1]], [ball[0], ball[1]]);
        }
        playing.before = Some(ball);
        if !sample.motion_ended {
            return false;
        }
        playing.over += 1;
        playing.speeds[0] += base_speed;
        playing.speeds[1] += joint_speed;
        playing.still = if still { playing.still + 1 } else { 0 };
        let rests = sample.ball_vel[0].hypot(sample.ball_vel[1]) < AT_REST;
        let decided = playing.crossing.is_some() || rests;
        let ready = decided && playing.still >= steps(self.setup, self.options.still_s);
        if !ready && playing.over < steps(self.setup, self.options.patience_s) {
            return false;
        }
        let goes_on = self.kicks.len() + 1 < self.options.kicks;
        // Nowhere to put a ball: the match is over, too.
        let next = if goes_on { self.draw.next(sample, self.anchor) } else { None };
        self.end_kick(sample, false, next.is_none());
        let Some(next) = next else { return true };
        self.playing = Playing::new(next, sample.step);
        self.pending = Some(next);
        false
    }

    fn next_kick(&mut self) -> Option<NextKick> {
        self.pending.take()
    }
}
