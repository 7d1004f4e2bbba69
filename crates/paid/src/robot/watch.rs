//! `--live` of a virtual robot: a page that looks on.

use std::cell::RefCell;
use std::rc::Rc;
use std::time::{Duration, Instant};

use paid_deploy::sim::{KickResult, VirtualG1, Watcher};
use paid_deploy::{Player, State, Status};
use paid_lanes::{Quat, Vec3};
use paid_live::{Belief, Body, Flags, Frame, Outcome, Shot, WatchPage, Watched};

use super::PlayerArgs;
use crate::failure::Failure;
use crate::live::LiveArgs;

/// Steps of 2 ms from one picture to the next: 50 pictures a second.
const EVERY: u32 = 10;
/// Time of a step `[s]`.
const STEP_S: f64 = 0.002;
/// How often somebody is looked for.
const PATIENCE: Duration = Duration::from_millis(50);
/// A simulation that is so far behind real time gives the time up.
const BEHIND: Duration = Duration::from_millis(100);
/// A pelvis below this lies `[m]`.
const LIES_M: f64 = 0.4;
/// Force from which the robot has touched the ball `[N]`.
const TOUCHED_N: f64 = 10.0;
/// Half of the goal's width `[m]`.
const GOAL_HALF_WIDTH_M: f64 = 1.0;

/// The page, shared by who shows the robot and who counts its shots.
#[derive(Clone)]
pub struct Watching {
    page: Rc<RefCell<WatchPage>>,
    anchor: usize,
}

impl Watching {
    /// Serves the page and prints its address, if it was asked for.
    pub fn open(live: &LiveArgs, args: &PlayerArgs, player: &Player) -> Result<Option<Self>, Failure> {
        if !live.live {
            return Ok(None);
        }
        let anchor = player.model.body_index(&player.spec.anchor_body).unwrap_or(0);
        let watched = Watched {
            policy: args.policy.display().to_string(),
            robot: &player.model,
            anchor,
            task: &player.task,
            clips: player.library.facts().iter().map(|clip| clip.name.clone()).collect(),
        };
        let knowledge = "what the virtual robot's senses say".to_owned();
        let page = WatchPage::start(watched, knowledge, &live.options()).map_err(Failure::input)?;
        println!("{}  <- open this in a browser to look on", page.url());
        Ok(Some(Self { page: Rc::new(RefCell::new(page)), anchor }))
    }

    /// Shows a robot. `waits`: simulated time passes only while somebody looks on, and not faster than real time.
    pub fn look_on(&self, waits: bool) -> LookOn {
        LookOn {
            watching: self.clone(),
            waits: waits.then(Clock::default),
            steps: 0,
            ball_quat: Quat([1.0, 0.0, 0.0, 0.0]),
            goal: [5.0, 0.0, 0.0],
            believed: None,
            kicking: false,
            touched: false,
            fallen: false,
        }
    }

    /// Counts a shot of a match. Who does not see it misses nothing that is not printed.
    pub fn count(&self, kick: &KickResult) {
        let outcome = match (kick.goal, kick.struck, kick.lateral_m) {
            (true, ..) => Outcome::Goal,
            (_, false, _) => Outcome::NoContact,
            (.., Some(_)) => Outcome::Wide,
            (.., None) => Outcome::Short,
        };
        let shot = Shot {
            number: 0,
            outcome,
            speed_m_s: kick.ball_speed,
            lateral_m: kick.lateral_m,
            miss_m: kick.lateral_m.map(|lateral| (lateral.abs() - GOAL_HALF_WIDTH_M).max(0.0)),
            ball: kick.ball,
            rolling: false,
            clip: kick.motion.clone(),
            engine: "MuJoCo",
            surface: "",
        };
        let _ = self.page.borrow_mut().count(shot);
    }

    /// Says something to all who look on.
    pub fn say(&self, words: &str) {
        let _ = self.page.borrow_mut().say(words);
    }
}

/// Keeps simulated time from running ahead of real time.
#[derive(Default)]
struct Clock {
    /// When simulated time was this `[s]`.
    begin: Option<(Instant, f64)>,
    /// Simulated seconds a second, a mean of the last ones.
    kept: f64,
    /// When the last picture was shown.
    last: Option<Instant>,
}

impl Clock {
    /// Waits until `now_s` is due.
    fn wait(&mut self, now_s: f64, page: &RefCell<WatchPage>) {
        while page.borrow().viewers() == 0 {
            (self.begin, self.last) = (None, None);
            std::thread::sleep(PATIENCE);
        }
        let (begin, from_s) = *self.begin.get_or_insert((Instant::now(), now_s));
        let due = begin + Duration::from_secs_f64(now_s - from_s);
        match due.checked_duration_since(Instant::now()) {
            Some(early) => std::thread::sleep(early),
            None if due.elapsed() > BEHIND => self.begin = Some((Instant::now(), now_s)),
            None => {}
        }
        let now = Instant::now();
        if let Some(last) = self.last.replace(now) {
            let rate = f64::from(EVERY) * STEP_S / now.duration_since(last).as_secs_f64().max(1e-6);
            self.kept += 0.05 * (rate.min(2.0) - self.kept);
        } else {
            self.kept = 1.0;
        }
    }
}

/// Shows a virtual robot on the page.
pub struct LookOn {
    watching: Watching,
    waits: Option<Clock>,
    steps: u32,
    ball_quat: Quat<f64>,
    goal: [f64; 3],
    /// The ball ahead of the torso and to its left, as the runtime has it `[m]`.
    believed: Option<[f64; 2]>,
    kicking: bool,
    touched: bool,
    fallen: bool,
}

impl LookOn {
    fn frame(&self, robot: &VirtualG1) -> Frame {
        let truth = robot.truth();
        let body = |at: &paid_physics::BodyState<f64>| Body { pos: at.pos.0, quat: at.rot.to_quat().0 };
        let torso = &truth.bodies[self.watching.anchor];
        let (s, c) = torso.rot.yaw().sin_cos();
        let belief = self.believed.map(|[ahead, left]| Belief {
            pos: [
                torso.pos.x() + c * ahead - s * left,
                torso.pos.y() + s * ahead + c * left,
                truth.ball.pos.z(),
            ]
            .map(|x| x as f32),
            deviation_m: 0.0,
            age_s: 0.0,
        });
        let kept = self.waits.as_ref().map_or(1.0, |clock| clock.kept);
        Frame {
            flags: Flags {
                fallen: self.fallen,
                late: kept < 0.95,
                touched: self.touched,
                kicking: self.kicking,
                ..Flags::default()
            },
            step: self.steps / EVERY,
            time_s: robot.now_us() as f64 * 1e-6,
            rate: [1.0, kept as f32],
            ball: Body { pos: truth.ball.pos.0, quat: self.ball_quat.0 },
            ball_speed: truth.ball.vel.norm() as f32,
            goal: self.goal.map(|x| x as f32),
            bodies: truth.bodies.iter().map(body).collect(),
            belief,
            ..Frame::default()
        }
    }
}

impl Watcher for LookOn {
    fn step(&mut self, robot: &VirtualG1) {
        let ball = &robot.truth().ball;
        let turn: Vec3<f64> = ball.ang_vel.scale(STEP_S);
        let angle = turn.norm();
        if angle > 1e-9 {
            let turn = Quat::from_axis_angle(turn.scale(1.0 / angle), angle);
            self.ball_quat = turn.mul(self.ball_quat).normalize();
        }
        self.touched |= self.kicking && ball.robot_force.norm() > TOUCHED_N;
        self.steps += 1;
        if !self.steps.is_multiple_of(EVERY) {
            return;
        }
        let lies = robot.truth().bodies[0].pos.z() < LIES_M;
        if lies && !self.fallen {
            let _ = self.watching.page.borrow_mut().fell();
        }
        self.fallen = lies;
        if let Some(clock) = &mut self.waits {
            clock.wait(robot.now_us() as f64 * 1e-6, &self.watching.page);
        }
        self.watching.page.borrow().show(self.frame(robot));
    }

    fn goal(&mut self, center: [f64; 2], heading: f64) {
        self.goal = [center[0], center[1], heading];
    }

    fn status(&mut self, status: &Status) {
        let kicking = status.state == State::Kick;
        if kicking && !self.kicking {
            self.touched = false;
        }
        (self.kicking, self.believed) = (kicking, status.ball_m);
    }

    fn stops(&mut self) -> bool {
        self.watching.page.borrow_mut().stop_asked()
    }
}
