//! Follows one shot: the ball until the shot is decided, the robot to its clip's end and as long as the options say.

use paid_task::preset::ReferenceSource;
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
    /// The robot follows a clip, in which it may fall after the shot is decided.
    follows_clip: bool,
    /// The ball no longer counts.
    decided: bool,
    /// Control steps until then.
    decided_steps: u32,
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
            follows_clip: setup.preset.reference != ReferenceSource::None,
            decided: false,
            decided_steps: 0,
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
        let joint_steps = u64::from(self.decided_steps) * self.effort.len() as u64;
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

impl Watch {
    /// Takes in where the ball is and what the torques are while the shot is open; returns the ball's horizontal speed `[m/s]`.
    fn follow_ball(&mut self, sample: &EnvSample) -> f64 {
        let ball = sample.ball_pos;
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
        let base = &sample.bodies[0];
        self.path.push([goal.local([base.pos[0], base.pos[1]]), goal.local([ball[0], ball[1]])]);
        speed
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
        let lies = fallen(base.pos[2] - sample.ground_m, base.rot[2][2], self.nominal_height_m);
        self.fell |= lies;
        self.fell_in_clip |= lies && !sample.motion_ended;
        let within = |steps: u32| since_kick.is_some_and(|s| s <= steps);
        self.fell_after_kick |= lies && within(self.window);
        self.fell_within |= lies && self.after.is_some_and(within);

        if !self.decided {
            self.decided_steps = sample.step;
            let speed = self.follow_ball(sample);
            let settled = self.crossing.is_some() || speed < AT_REST;
            self.decided = settled && since_kick.is_some_and(|steps| steps >= self.window);
        }
        let enough = if let Some(since_kick) = since_kick {
            let watched = since_kick >= self.after.unwrap_or(0);
            // A robot that lies on the ground has nothing more to show.
            self.decided && (self.fell || watched && (sample.motion_ended || !self.follows_clip))
        } else {
            // A robot that has not kicked two seconds after the motion's end will not.
            sample.motion_ended && sample.step as usize >= sample.frame + self.window as usize
        };
        enough || ended.is_some()
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use std::sync::Arc;

    use paid_lanes::Isa;
    use paid_play::ReferenceLibrary;
    use paid_robot::{RobotModel, RobotSpec};
    use paid_task::{BodySample, TaskPreset};

    use super::*;
    use crate::engine::EngineChoice;
    use crate::monitor::Monitor;

    /// The paper's shots, with a robot that stands for two frames as the only motion.
    pub(crate) fn setup() -> EvalSetup {
        let (robot, spec) = (RobotModel::g1(), RobotSpec::g1());
        let library = ReferenceLibrary::standing(&robot, &spec, 0.02).expect("the built-in robot");
        EvalSetup {
            engine: EngineChoice::Builtin,
            isa: Isa::Portable,
            robot,
            spec,
            library: Arc::new(library),
            preset: TaskPreset::builtin("paper_stage2").expect("built in"),
            threads: 1,
            seed: 1,
            monitor: Monitor::default(),
            ranks: Arc::new(paid_train::Alone),
        }
    }

    /// The setup's standing robot, `step` control steps into a clip of `frames` frames. The ball rests 1 m ahead, the goal is 5 m ahead.
    pub(crate) fn sample(setup: &EvalSetup, frames: usize, step: u32) -> EnvSample {
        let (joints, bodies) = (setup.robot.joints.len(), setup.robot.bodies.len());
        let stands = |pos: &[f64; 3]| BodySample {
            pos: *pos,
            rot: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            com_vel: [0.0; 3],
            ang_vel: [0.0; 3],
        };
        EnvSample {
            motion: 0,
            frame: (step as usize).min(frames - 1),
            step,
            motion_ended: step as usize + 1 >= frames,
            bodies: setup.library.clips()[0].body_pos[..bodies].iter().map(stands).collect(),
            joint_pos: vec![0.0; joints],
            joint_target: vec![0.0; joints],
            joint_vel: vec![0.0; joints],
            joint_torque: vec![0.0; joints],
            contact_force: vec![[0.0; 3]; bodies],
            ground_m: 0.0,
            ball_pos: [1.0, 0.0, 0.11],
            ball_vel: [0.0; 3],
            ball_force: [0.0; 3],
            goal_pos: [5.0, 0.0, 0.11],
            reference_anchor: ([0.0; 2], 0.0),
            heading: 0.0,
            kick: None,
            rewards: Vec::new(),
        }
    }

    /// Frames of the shots' clip.
    const FRAMES: usize = 289;
    /// The foot meets the ball.
    const KICK: u32 = 60;
    /// Two seconds later.
    const DECIDED: u32 = 160;

    /// Plays a shot whose ball passes the goal plane 1 s after the kick, at 4 m/s; `change` alters a sample before it is seen.
    fn play(setup: &EvalSetup, after_s: Option<f64>, change: impl Fn(&mut EnvSample)) -> Outcome {
        let options = ShootingOptions { after_s, ..ShootingOptions::default() };
        let mut watch = Watch::new(setup, &options);
        let enough = (0..1000).any(|step| {
            let mut sample = sample(setup, FRAMES, step);
            if step >= KICK {
                sample.kick = Some(KickEvent {
                    step: KICK,
                    foot: 0,
                    correct: true,
                    body: None,
                    foot_vel: [5.0, 0.0, 0.0],
                    ball_vel_after: None,
                });
                sample.ball_pos[0] += 4.0 * f64::from(step - KICK) * 0.02;
                sample.ball_vel[0] = 4.0;
            }
            change(&mut sample);
            watch.observe(&sample, None)
        });
        assert!(enough, "the shot ends");
        let trial = Trial {
            place: [1.0, 0.0],
            repeat: 0,
            displacement: [0.0; 2],
            ball: [1.0, 0.0],
            ball_velocity: [0.0; 2],
            goal: [5.0, 0.0],
            motion: 0,
        };
        watch.outcome(trial, setup)
    }

    fn falls_at(fall: u32) -> impl Fn(&mut EnvSample) {
        move |sample| {
            if sample.step >= fall {
                sample.bodies[0].pos[2] = 0.1;
            }
        }
    }

    #[test]
    fn a_fall_between_the_balls_passage_and_the_clips_end_counts() {
        let outcome = play(&setup(), None, falls_at(250));
        assert!(outcome.fell_in_clip && outcome.fell && !outcome.fell_after_kick, "{outcome:?}");
        assert_eq!((outcome.steps, outcome.goal), (250, true));
        // A robot that falls before the shot is decided is watched until then.
        let outcome = play(&setup(), None, falls_at(100));
        assert!(outcome.fell_in_clip && outcome.fell_after_kick, "{outcome:?}");
        assert_eq!(outcome.steps, DECIDED);
    }

    #[test]
    fn a_shot_on_its_feet_ends_with_its_clip_or_without_one_when_it_is_decided() {
        let mut setup = setup();
        let outcome = play(&setup, None, |_| {});
        assert_eq!((outcome.fell, outcome.fell_in_clip, outcome.steps), (false, false, 288));
        // Eight seconds after the kick are later, one second is not.
        assert_eq!(play(&setup, Some(8.0), |_| {}).steps, KICK + 400);
        assert_eq!(play(&setup, Some(1.0), |_| {}).steps, 288);
        setup.preset.reference = ReferenceSource::None;
        let never_ends = |sample: &mut EnvSample| sample.motion_ended = false;
        assert_eq!(play(&setup, None, never_ends).steps, DECIDED);
    }

    #[test]
    fn what_comes_after_a_shot_is_decided_changes_nothing_but_falls() {
        for after_s in [None, Some(8.0)] {
            nothing_but_falls(after_s);
        }
    }

    fn nothing_but_falls(after_s: Option<f64>) {
        let setup = setup();
        let limits: Vec<f64> = setup.robot.joints.iter().map(|joint| joint.effort_limit).collect();
        // The ball comes to rest 3 m ahead of the plane. A second push takes it there, with all torques at their limits.
        let outcome = play(&setup, after_s, |sample| {
            if sample.step >= KICK {
                let pushed = f64::from(sample.step.saturating_sub(200));
                sample.ball_pos[0] = 2.0 + 0.1 * pushed;
                sample.ball_vel[0] = if sample.step < 100 {
                    1.5
                } else if pushed > 0.0 {
                    5.0
                } else {
                    0.0
                };
            }
            if sample.step > DECIDED {
                sample.joint_torque.clone_from(&limits);
            }
        });
        assert_eq!((outcome.goal, outcome.lateral_m, outcome.plane_speed), (false, None, None));
        assert_eq!((outcome.peak_ball_speed, outcome.torque_saturation), (1.5, 0.0));
        assert_eq!(outcome.steps, if after_s.is_some() { KICK + 400 } else { 288 });
        assert_eq!(outcome.path.len(), 161);
    }
}
