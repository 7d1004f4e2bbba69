//! Follows one shot.

use paid_task::{EnvSample, KickEvent};

use super::score::Outcome;
use super::{ShootingOptions, Trial};
use crate::episodes::{Ending, EvalSetup, Observer};
use crate::metrics::shooting::{Crossing, Goal, direction_cosine, fallen};

/// A fall within this time after the kick counts against the kick `[s]`.
const FALL_WINDOW_S: f64 = 2.0;
/// A ball slower than this has come to rest `[m/s]`.
const AT_REST: f64 = 0.05;

/// From this share of its limit on a torque counts as saturated.
const SATURATED: f64 = 0.99;

/// What happened so far.
pub(crate) struct Watch {
    effort: Vec<f64>,
    saturated: u64,
    half_width: f64,
    nominal_height_m: f64,
    window: u32,
    /// Control steps after the kick for which the robot is watched.
    after: Option<u32>,
    before: Option<[f64; 3]>,
    ball_at_impact: Option<[f64; 3]>,
    goal: [f64; 3],
    kick: Option<KickEvent>,
    crossing: Option<(Crossing, u32)>,
    plane_speed: Option<f64>,
    fell_after_kick: bool,
    fell: bool,
    fell_in_clip: bool,
    fell_within: bool,
    peak_ball_speed: f64,
    path: Vec<[[f64; 2]; 2]>,
    steps: u32,
}

impl Watch {
    pub(crate) fn new(setup: &EvalSetup, options: &ShootingOptions) -> Self {
        let steps = |seconds: f64| (seconds / setup.preset.control_dt_s()).round() as u32;
        Self {
            effort: setup.robot.joints.iter().map(|j| j.effort_limit).collect(),
            saturated: 0,
            plane_speed: None,
            half_width: options.goal_half_width_m,
            nominal_height_m: setup.spec.nominal_height_m,
            window: steps(FALL_WINDOW_S),
            after: options.after_s.map(steps),
            before: None,
            ball_at_impact: None,
            goal: [0.0; 3],
            kick: None,
            crossing: None,
            fell_after_kick: false,
            fell: false,
            fell_in_clip: false,
            fell_within: false,
            peak_ball_speed: 0.0,
            path: Vec::new(),
            steps: 0,
        }
    }

    pub(crate) fn outcome(self, trial: Trial, setup: &EvalSetup) -> Outcome {
        let kick = self.kick.as_ref();
        let out = kick.and_then(|k| k.ball_vel_after);
        let goal = [self.goal[0], self.goal[1]];
        let cosine = self
            .ball_at_impact
            .zip(out)
            .and_then(|(ball, v)| direction_cosine([v[0], v[1]], [ball[0], ball[1]], goal));
        let body = kick.and_then(|k| k.body);
        let feet = setup.spec.feet.each_ref().map(|name| setup.robot.body_index(name));
        let joint_steps = u64::from(self.steps) * self.effort.len() as u64;
        let norm = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
        Outcome {
            motion_name: setup.library.facts()[trial.motion].name.clone(),
            trial,
            contact: kick.is_some(),
            correct_foot: kick.is_some_and(|k| k.correct),
            foot_contact: body.is_some() && feet.contains(&body),
            body: body.and_then(|b| setup.robot.bodies.get(b)).map(|b| b.name.clone()),
            foot: kick.map(|k| k.foot),
            kick_time_s: kick.map(|k| f64::from(k.step) * setup.preset.control_dt_s()),
            foot_speed: kick.map(|k| norm(k.foot_vel)),
            goal: self.crossing.is_some_and(|(c, _)| c.inside),
            lateral_m: self.crossing.map(|(c, _)| c.lateral),
            plane_speed: self.plane_speed,
            torque_saturation: self.saturated as f64 / joint_steps.max(1) as f64,
            goal_time_s: self.crossing.map(|(_, step)| f64::from(step) * setup.preset.control_dt_s()),
            cosine,
            ball_speed: out.map(|v| v[0].hypot(v[1])),
            ball_rise: out.map(|v| v[2]),
            peak_ball_speed: self.peak_ball_speed,
            fell_after_kick: self.fell_after_kick,
            fell: self.fell,
            fell_in_clip: self.fell_in_clip,
            fell_within: self.after.map(|_| self.fell_within),
            steps: self.steps,
            path: self.path,
        }
    }
}

impl Observer for Watch {
    fn observe(&mut self, sample: &EnvSample, ended: Option<Ending>) -> bool {
        self.steps = sample.step;
        self.goal = sample.goal_pos;
        let ball = sample.ball_pos;
        if let Some(kick) = &sample.kick {
            if self.kick.is_none() {
                self.ball_at_impact = self.before.or(Some(ball));
            }
            self.kick = Some(kick.clone());
        }
        let since_kick = self.kick.as_ref().map(|k| sample.step.saturating_sub(k.step));
        let base = &sample.bodies[0];
        let lies = fallen(base.pos[2], base.rot[2][2], self.nominal_height_m);
        self.fell |= lies;
        self.fell_in_clip |= lies && !sample.motion_ended;
        let within = |steps: u32| since_kick.is_some_and(|s| s <= steps);
        self.fell_after_kick |= lies && within(self.window);
        self.fell_within |= lies && self.after.is_some_and(within);

        let goal = Goal {
            center: [self.goal[0], self.goal[1]],
            heading: sample.heading,
            half_width: self.half_width,
        };
        // Only a kicked ball can score.
        if let (Some(before), Some(_), None) = (self.before, &self.kick, &self.crossing) {
            self.crossing =
                goal.crossing([before[0], before[1]], [ball[0], ball[1]]).map(|c| (c, sample.step));
            self.plane_speed = self.crossing.map(|_| sample.ball_vel[0].hypot(sample.ball_vel[1]));
        }
        if sample.step > 0 {
            let limits = sample.joint_torque.iter().zip(&self.effort);
            self.saturated +=
                limits.filter(|(torque, limit)| torque.abs() >= SATURATED * **limit).count() as u64;
        }
        let speed = sample.ball_vel[0].hypot(sample.ball_vel[1]);
        if self.kick.is_some() {
            self.peak_ball_speed = self.peak_ball_speed.max(speed);
        }
        self.before = Some(ball);
        self.path.push([goal.local([base.pos[0], base.pos[1]]), goal.local([ball[0], ball[1]])]);

        let settled = self.crossing.is_some() || speed < AT_REST;
        let enough = match since_kick {
            // Whoever lies has nothing more to show.
            Some(steps) => steps >= self.window && settled && (self.fell || steps >= self.after.unwrap_or(0)),
            // Whoever has not kicked two seconds after the motion's end will not.
            None => sample.motion_ended && sample.step as usize >= sample.frame + self.window as usize,
        };
        enough || ended.is_some()
    }
}
