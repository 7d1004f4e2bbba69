//! One kick with onboard perception.

use std::time::Instant;

use cpu_time::ThreadTime;
use paid_lanes::{Mat3, Quat, Vec3};
use paid_play::{BelievedScene, KickTimes, RollingBall, motion_for};
use paid_policy::{StepBuffers, VecEnv};
use paid_task::{EvalControl, Shown};
use paid_track::{Pose, turned};
use paid_world::{Believed, Recorder, Sight, seconds};

use super::judge::EyesOutcome;
use super::kick::{Kick, KickLog, LEAST_SHOWN, SUBSTEPS};
use super::senses::{Moment, eyes_error, quat_of};
use super::stage::{STEP_NS, Stage, StartFrame};
use super::{Cause, with_motion};
use crate::EvalError;
use crate::episodes::{Ending, Observer};
use crate::policy::DriverInput;
use crate::shooting::{Outcome, Trial, Watch, rules_of, start_of};

/// Control steps for which the robot stands and watches: LiDAR odometry starts from standing for 0.5 s, then 0.7 s of images.
const STAND_STEPS: u64 = 60;
/// Control steps in which it then moves to the first frame of the chosen motion.
const READY_STEPS: u64 = 30;
/// Without a rule for what is shown after the strike, the estimate is evaluated this long before it `[s]`.
const JUDGED_S: f64 = 0.2;

/// The outcome of a trial.
pub(super) struct Played {
    pub outcome: Outcome,
    pub eyes: EyesOutcome,
    pub log: KickLog,
}

impl Stage<'_> {
    /// Plays a trial; `None` if the evaluation was stopped before its end.
    pub(super) fn play(&mut self, number: usize, trial: &Trial) -> Result<Option<Played>, EvalError> {
        let begin = ThreadTime::now();
        let standing = Pose { rot: Mat3::identity(), pos: Vec3(self.base) };
        let rolling = Rolling {
            place: trial.ball,
            velocity: trial.ball_velocity,
            decay: paid_task::roll_decay(&self.setup.ball()),
            radius: self.setup.preset.ball_params.radius_m,
            start_ns: (STAND_STEPS + READY_STEPS) * STEP_NS,
        };
        let first = self.moment(0, &standing, &self.standing, Vec3::zero(), rolling.at(0));
        let recorder = match &self.eyes.record {
            Some((recorded, path)) if *recorded == number => {
                Some(Recorder::create(path, &self.sight()?).map_err(eyes_error)?)
            }
            _ => None,
        };
        let mut kick = Kick {
            senses: self.senses(number, trial, &first.torso)?,
            sight: Sight::new(self.sight()?).map_err(eyes_error)?,
            recorder,
            truths: Vec::new(),
            eyes: EyesOutcome::default(),
            log: KickLog { start_s: seconds(rolling.start_ns), ..KickLog::default() },
            start_from_odometry: None,
            placed_ns: None,
            when_seen: None,
            begin,
        };
        let camera = first.torso.compose(&Pose::g1_camera());
        let intrinsics = paid_vision::Intrinsics::g1_color();
        let mut believed = None;
        for step in 0..=STAND_STEPS {
            let at_ns = step * STEP_NS;
            kick.hold(at_ns, &first.torso);
            let moment = self.moment(at_ns, &standing, &self.standing, Vec3::zero(), rolling.at(at_ns));
            if step == STAND_STEPS {
                let outline = intrinsics.sphere_box(camera.inverse_point(moment.ball), rolling.radius);
                kick.eyes.in_view_at_start = outline.is_some_and(|outline| {
                    outline.min.iter().all(|v| *v >= 0.0)
                        && outline.max[0] <= intrinsics.width as f64
                        && outline.max[1] <= intrinsics.height as f64
                });
            }
            believed = Some(kick.step(&moment, f64::INFINITY, true)?);
        }
        let chosen = believed.and_then(|believed| {
            let motion = self.choose(&believed, &rolling)?;
            kick.start_from_odometry = kick.alignment(&believed).map(|a| a.inverse());
            kick.eyes.start_error_m = kick.error(&believed);
            Some(motion)
        });
        let watch = match chosen {
            Some(motion) => {
                let kicked =
                    self.kick(&mut kick, number, &with_motion(trial, motion), &standing, &rolling)?;
                let Some(watch) = kicked else { return Ok(None) };
                watch
            }
            None => Watch::new(&self.setup, self.options),
        };
        let trial = chosen.map_or_else(|| trial.clone(), |motion| with_motion(trial, motion));
        let outcome = watch.outcome(trial, &self.setup);
        let Kick { mut eyes, log, senses, recorder, begin, placed_ns, .. } = kick;
        if let Some(recorder) = recorder {
            recorder.finish().map_err(eyes_error)?;
        }
        let first_ns = placed_ns.unwrap_or(u64::MAX);
        let placed = senses.showed.iter().filter(|showed| showed.captured_ns >= first_ns);
        let placed: Vec<f64> = placed.map(|showed| showed.shown).collect();
        eyes.pictures = placed.len();
        eyes.with_ball = placed.iter().filter(|shown| **shown >= LEAST_SHOWN).count();
        eyes.cause = (!outcome.goal).then(|| Cause::of(&eyes));
        eyes.cpu_s = begin.elapsed().as_secs_f64();
        Ok(Some(Played { outcome, eyes, log }))
    }

    /// The motion for the ball as it is believed; `None` if none is.
    fn choose(&self, believed: &Believed, rolling: &Rolling) -> Option<usize> {
        let (torso, ball) = (believed.torso?, believed.ball?);
        if ball.state == paid_track::BallState::Lost {
            return None;
        }
        let (s, c) = torso.rot.yaw().sin_cos();
        let local = |[x, y]: [f64; 2]| [c * x + s * y, c * y - s * x];
        let [x, y] = ball.belief.ball.position;
        let velocity = local(ball.belief.ball.velocity);
        let wait = seconds(READY_STEPS * STEP_NS);
        let place = local([x - torso.pos.x(), y - torso.pos.y()]);
        let ball = RollingBall { place, velocity, decay: rolling.decay }.after(wait);
        let task = &self.setup.preset;
        Some(motion_for(self.facts(), &ball.as_chosen_by(task.predicts_ball()), task.control_dt_s()))
    }

    /// From the choice to the end; `None` if the evaluation was stopped before it.
    fn kick(
        &mut self,
        kick: &mut Kick,
        number: usize,
        trial: &Trial,
        standing: &Pose,
        rolling: &Rolling,
    ) -> Result<Option<Watch>, EvalError> {
        let facts = self.facts()[trial.motion].clone();
        let start = StartFrame::of(&facts);
        let mut task = self.task(number)?;
        let (rules, steps) = rules_of(self.options, self.setup.preset.control_dt_s());
        task.set_rules(rules);
        task.force_start(0, &start_of(trial))?;
        let sample = task.sample(0)?;
        let dt_s = self.setup.preset.control_dt_s();
        let strike_s = facts.times_from(0, dt_s).to_strike_s;
        let predicts = self.setup.preset.predicts();
        kick.log.strike_s = Some(kick.log.start_s + strike_s);
        let first = self.moment_of(rolling.start_ns, &sample, &start);
        self.get_ready(kick, standing, &first, rolling, strike_s)?;

        let goal_z = rolling.radius;
        let goal = kick.start_from_odometry.map_or(trial.goal, |aligned| {
            let [x, y, _] = aligned.inverse_point([trial.goal[0], trial.goal[1], goal_z]);
            [x, y]
        });
        let times = self.setup.preset.ball.after_strike.times();
        let keep_open = kick.recorder.is_some() || self.eyes.log == Some(number);
        let [policy_dim, critic_dim, action_dim] = Self::sizes(&task);
        let (mut observation, mut critic) = (vec![0.0; policy_dim], vec![0.0; critic_dim]);
        let (mut action, mut reward) = (vec![0.0; action_dim], [0.0]);
        let (mut terminated, mut truncated) = ([0], [0]);
        let mut watch = Watch::new(&self.setup, self.options);
        watch.observe(&sample, None);
        self.policy.begin(1);
        let mut moment = first;
        let mut shown = None;
        for step in 0..steps {
            if self.setup.monitor.stopped() {
                return Ok(None);
            }
            let KickTimes { to_strike_s, to_contact_s } = facts.times_from(step, dt_s);
            // Once the policy is shown only the ball's position before the kick, the camera may rest; odometry continues.
            let open = keep_open || times.is_none_or(|times| to_strike_s > -times.from_s - 0.1);
            let believed = kick.step(&moment, to_strike_s, open)?;
            if kick.eyes.strike_error_m.is_none()
                && to_strike_s <= times.map_or(JUDGED_S, |times| times.captured_s)
            {
                kick.judge_strike(&believed);
            }
            let believed_scene = scene(&believed, goal, rolling, to_contact_s, predicts);
            shown = believed_scene.or(shown);
            let Some(now) = &shown else { return Err(eyes_error("no estimate at the start of a kick")) };
            task.show(0, Some(now))?;
            let begin = Instant::now();
            task.observe(&mut [&mut observation, &mut critic]);
            let observed = Instant::now();
            let input = DriverInput { observations: &observation, envs: 1, world: &task };
            self.policy.act(input, &mut action)?;
            let acted = Instant::now();
            if let Some(index) = action.iter().position(|a| !a.is_finite()) {
                return Err(EvalError::Action { action: index, trial: number, step, value: action[index] });
            }
            task.step(&action, StepBuffers::new(&mut reward, &mut terminated, &mut truncated));
            self.setup.monitor.spend(1, acted.elapsed() + (observed - begin), acted - observed);
            let at_ns = moment.at_ns;
            let trace = task.simulator().trace(0);
            let dt_ns = STEP_NS / (trace.len() as u64).max(1);
            for (k, (pos, m)) in trace.iter().enumerate().skip(1) {
                let rot = Mat3([[m[0], m[1], m[2]], [m[3], m[4], m[5]], [m[6], m[7], m[8]]]);
                kick.senses.torso(at_ns + k as u64 * dt_ns, &start.local(&Pose { rot, pos: Vec3(*pos) }));
            }
            let sample = task.sample(0)?;
            let ended = if terminated[0] != 0 {
                Some(Ending::Failed)
            } else {
                (truncated[0] != 0).then_some(Ending::Over)
            };
            if watch.observe(&sample, ended) {
                break;
            }
            moment = self.moment_of(at_ns + STEP_NS, &sample, &start);
        }
        Ok(Some(watch))
    }

    /// From standing to the first frame of the motion.
    fn get_ready(
        &self,
        kick: &mut Kick,
        standing: &Pose,
        first: &Moment,
        rolling: &Rolling,
        strike_s: f64,
    ) -> Result<(), EvalError> {
        let begin_ns = STAND_STEPS * STEP_NS;
        let to = Pose { rot: first.bodies[0].rot(), pos: first.bodies[0].pos };
        let (from_quat, to_quat) = (quat_of(&standing.rot), first.bodies[0].quat);
        let at = |at_ns: u64| {
            let share = (at_ns - begin_ns) as f64 / (READY_STEPS * STEP_NS) as f64;
            let way = share * share * (3.0 - 2.0 * share);
            let pos = standing.pos + (to.pos - standing.pos).scale(way);
            let joints: Vec<f64> =
                self.standing.iter().zip(&first.joints).map(|(a, b)| a + way * (b - a)).collect();
            let quat: Quat<f64> = turned(from_quat, to_quat, way);
            (Pose { rot: quat.to_mat(), pos }, joints)
        };
        let dt_ns = STEP_NS / SUBSTEPS;
        let mut before = None::<Pose>;
        for step in 1..=READY_STEPS {
            let end_ns = begin_ns + step * STEP_NS;
            for k in (1..SUBSTEPS).rev() {
                let (base, joints) = at(end_ns - k * dt_ns);
                let moment = self.moment(end_ns - k * dt_ns, &base, &joints, Vec3::zero(), [[0.0; 3]; 2]);
                kick.senses.torso(moment.at_ns, &moment.torso);
                before = Some(moment.torso);
            }
            if step == READY_STEPS {
                break;
            }
            let (base, joints) = at(end_ns);
            let mut moment = self.moment(end_ns, &base, &joints, Vec3::zero(), rolling.at(end_ns));
            if let Some(before) = before {
                // A small turn: its vector is the axis of the difference.
                let turn = moment.torso.rot.mul_mat(&before.rot.transpose()).0;
                let half = Vec3([turn[2][1] - turn[1][2], turn[0][2] - turn[2][0], turn[1][0] - turn[0][1]]);
                moment.torso_rate = half.scale(0.5 / seconds(dt_ns));
            }
            let to_strike_s = strike_s + seconds(rolling.start_ns - end_ns);
            kick.step(&moment, to_strike_s, true)?;
        }
        Ok(())
    }
}

/// Ball and goal as the policy is shown them, `to_contact_s` before its foot meets the ball `[s]`; `None` while something of it is not known.
fn scene(
    believed: &Believed,
    goal: [f64; 2],
    rolling: &Rolling,
    to_contact_s: f64,
    predicts: bool,
) -> Option<Shown> {
    let (base, ball) = (believed.base?, believed.ball?);
    let z = believed.floor_m? + rolling.radius;
    let [x, y] = ball.belief.ball.position;
    let believed = BelievedScene {
        ball: Vec3([x, y, z]),
        velocity: ball.belief.ball.velocity,
        decay: rolling.decay,
        goal: Vec3([goal[0], goal[1], z]),
    };
    let base = paid_policy::Pose { pos: base.pos, rot: base.rot };
    Some(Shown { scene: believed.view(&base, to_contact_s, predicts), base })
}

/// The trial's ball before its start.
struct Rolling {
    place: [f64; 2],
    velocity: [f64; 2],
    decay: f64,
    radius: f64,
    start_ns: u64,
}

impl Rolling {
    /// Center and velocity before the start: it rolls to its place, and was faster.
    fn at(&self, at_ns: u64) -> [[f64; 3]; 2] {
        let age_s = seconds(self.start_ns.saturating_sub(at_ns));
        let grown = (self.decay * age_s).exp();
        let way = if self.decay * age_s < 1e-9 { age_s } else { (grown - 1.0) / self.decay };
        let [x, y] = [0, 1].map(|k| self.place[k] - way * self.velocity[k]);
        let [vx, vy] = self.velocity.map(|v| v * grown);
        [[x, y, self.radius], [vx, vy, 0.0]]
    }
}
