//! `--live` of a virtual robot: a page to watch it.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

use paid_eval::metrics::shooting::fallen;
use paid_lanes::Quat;
use paid_live::{Belief, Body, Flags, Frame, Outcome, Pace, Pose2, Shot, WatchPage, Watched};
use paid_robot_program::PlayerArgs;
use paid_runtime::{Player, State, Status};
use paid_twin::{KickResult, STEP_US, VirtualG1, Watcher, trained_task};

use crate::failure::Failure;
use crate::live::LiveArgs;

/// Simulated time from one frame of the page to the next `[us]`.
const PICTURE_US: u64 = 20_000;
/// How often to check for viewers.
const PATIENCE: Duration = Duration::from_millis(50);
/// Force from which the robot has touched the ball `[N]`.
const TOUCHED_N: f64 = 10.0;

/// Index of the body that carries the camera.
pub(super) fn anchor(player: &Player) -> usize {
    player.model.body_index(&player.spec.anchor_body).unwrap_or(0)
}

/// The ball is in view if its last image is at most this old `[s]`.
const IN_VIEW_S: f32 = 0.2;

/// The runtime's estimate of the ball, if it has one, in the world: the torso is at `axes`, the ball's center at this height `[m]`.
pub(super) fn believed(status: &Status, axes: &Pose2, height_m: f64) -> Option<Belief> {
    status.ball_m.map(|ball| axes.point(ball)).map(|[x, y]| Belief {
        pos: [x, y, height_m].map(|x| x as f32),
        deviation_m: status.ball_deviation_m as f32,
        age_s: status.ages_s[2] as f32,
    })
}

/// True if what is believed was seen just now.
pub(super) fn in_view(belief: Option<&Belief>) -> bool {
    belief.is_some_and(|belief| belief.age_s < IN_VIEW_S)
}

/// Serves a page to watch a robot with this player: what simulates it, and what the page's stop button does, which sets `asked`.
pub(super) fn serve(
    live: &LiveArgs,
    args: &PlayerArgs,
    player: &Player,
    [engine, stop]: [&'static str; 2],
    knowledge: &str,
    asked: &Arc<AtomicBool>,
) -> Result<WatchPage, Failure> {
    let task = trained_task(player)?;
    let watched = Watched {
        policy: args.policy.display().to_string(),
        robot: &player.model,
        anchor: anchor(player),
        task: &task,
        clips: player.library.facts().iter().map(|clip| clip.name.clone()).collect(),
        engine,
        stop,
    };
    WatchPage::start_with_stop(watched, knowledge.to_owned(), &live.options(), asked).map_err(Failure::input)
}

/// The page, shared by who shows the robot and who counts its shots.
#[derive(Clone)]
pub struct Watching {
    page: Rc<RefCell<WatchPage>>,
    anchor: usize,
    nominal_height_m: f64,
}

impl Watching {
    /// Serves the page and prints its address, if it was asked for.
    pub fn open(live: &LiveArgs, args: &PlayerArgs, player: &Player) -> Result<Option<Self>, Failure> {
        if !live.live {
            return Ok(None);
        }
        let knowledge = "what the virtual robot's sensors report";
        let stop = "The robot is damped";
        let page = serve(live, args, player, ["MuJoCo", stop], knowledge, &Arc::default())?;
        let anchor = anchor(player);
        println!("{}  <- open this in a browser to watch", page.url());
        let nominal_height_m = player.spec.nominal_height_m;
        Ok(Some(Self { page: Rc::new(RefCell::new(page)), anchor, nominal_height_m }))
    }

    /// Shows a robot. `waits`: simulated time passes only while the page is open, and not faster than real time.
    pub fn look_on(&self, waits: bool) -> LookOn {
        LookOn {
            watching: self.clone(),
            pace: waits.then(|| Pace::new(Instant::now())),
            ball_quat: Quat::identity(),
            goal: [5.0, 0.0, 0.0],
            told: None,
            touched: false,
            fallen: false,
        }
    }

    /// Counts a shot of a match. Who does not see it misses nothing that is not printed.
    pub fn count(&self, kick: &KickResult) {
        let (outcome, miss_m) = Outcome::judged(kick.goal, kick.struck, kick.lateral_m);
        let shot = Shot {
            number: 0,
            outcome,
            speed_m_s: kick.ball_speed,
            lateral_m: kick.lateral_m,
            miss_m,
            ball: kick.ball,
            rolling: false,
            clip: kick.motion.clone(),
            engine: "MuJoCo",
            surface: "",
        };
        let _ = self.page.borrow_mut().count(shot);
    }

    /// Shows a message to all viewers.
    pub fn say(&self, words: &str) {
        let _ = self.page.borrow_mut().say(words);
    }
}

/// Shows a virtual robot on the page.
pub struct LookOn {
    watching: Watching,
    /// Of a simulation that could run ahead of real time.
    pace: Option<Pace>,
    ball_quat: Quat<f64>,
    goal: [f64; 3],
    /// What the runtime said last.
    told: Option<Status>,
    touched: bool,
    fallen: bool,
}

impl LookOn {
    fn kicking(&self) -> bool {
        self.told.as_ref().is_some_and(|status| status.state == State::Kick)
    }

    fn frame(&self, robot: &VirtualG1) -> Frame {
        let truth = robot.truth();
        let body = |at: &paid_physics::BodyState<f64>| Body { pos: at.pos.0, quat: at.rot.to_quat().0 };
        let torso = &truth.bodies[self.watching.anchor];
        let axes = Pose2 { xy: [torso.pos.x(), torso.pos.y()], heading: torso.rot.yaw() };
        let height = truth.ball.pos.z();
        let belief = self.told.as_ref().and_then(|status| believed(status, &axes, height));
        Frame {
            flags: Flags {
                fallen: self.fallen,
                late: self.pace.is_some_and(|pace| pace.late()),
                touched: self.touched,
                kicking: self.kicking(),
                in_view: in_view(belief.as_ref()),
                ..Flags::default()
            },
            step: (robot.now_us() / PICTURE_US) as u32,
            time_s: robot.now_us() as f64 * 1e-6,
            rate: [1.0, self.pace.map_or(1.0, |pace| pace.kept())],
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
        self.ball_quat = self.ball_quat.integrate(ball.ang_vel, STEP_US as f64 * 1e-6);
        self.touched |= self.kicking() && ball.robot_force.norm() > TOUCHED_N;
        if !robot.now_us().is_multiple_of(PICTURE_US) {
            return;
        }
        let base = &robot.truth().bodies[0];
        let lies = fallen(base.pos.z(), base.rot.0[2][2], self.watching.nominal_height_m);
        if lies && !self.fallen {
            let _ = self.watching.page.borrow_mut().fell();
        }
        self.fallen = lies;
        if let Some(pace) = &mut self.pace {
            while self.watching.page.borrow().viewers() == 0 {
                std::thread::sleep(PATIENCE);
                pace.resume(Instant::now(), 1.0);
            }
            std::thread::sleep(pace.due().saturating_duration_since(Instant::now()));
            pace.stepped(Instant::now(), PICTURE_US as f64 * 1e-6, 1.0);
        }
        self.watching.page.borrow().show(self.frame(robot));
    }

    fn goal(&mut self, center: [f64; 2], heading: f64) {
        self.goal = [center[0], center[1], heading];
    }

    fn status(&mut self, status: &Status) {
        if status.state == State::Kick && !self.kicking() {
            self.touched = false;
        }
        self.told = Some(*status);
    }

    fn stops(&mut self) -> bool {
        self.watching.page.borrow().stop_asked()
    }
}
