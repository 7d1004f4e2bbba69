//! The rules of play: what a visitor's command does, when a shot is over, what comes next.

mod ground;
mod shot;
mod stance;

use paid_eval::engine::EngineChoice;
use paid_eval::metrics::shooting::{Goal, fallen};
use paid_eval::policy::Driver;
use paid_eval::shooting::{Grid, Placement};
use paid_eval::subject::Subject;
use paid_lanes::rng::Rng;

use crate::arena::{Arena, KickPlan, array};
use crate::board::Board;
use crate::wire::{Flags, Frame};
use crate::{Command, LiveError, Pose2};

use shot::{Playing, Verdict};

/// Half of the goal's width `[m]`: the protocols'.
pub(crate) const GOAL_HALF_WIDTH_M: f64 = 1.0;
/// Height of the bar `[m]`: the MuJoCo scene's.
pub(crate) const GOAL_HEIGHT_M: f64 = 1.0;
/// Depth of the net `[m]`.
const NET_M: f64 = 0.7;
/// A ball let go slower than this lies still `[m/s]`.
const FLICK_M_S: f64 = 0.35;
/// Time from the end of a shot to the next automatic ball `[s]`.
const PAUSE_S: f64 = 1.2;
/// How long a pushed robot is simulated if it does not fall `[s]`.
const PUSHED_S: f64 = 3.0;
/// A ball faster than this along an axis rolls `[m/s]`.
const ROLLS_M_S: f64 = 0.03;
/// How long a robot lies on the ground before it is put on its feet `[s]`.
const DOWN_S: f64 = 1.5;
/// A hand that sends nothing for this long lets go of the ball `[s]`.
const GRIP_S: f64 = 2.0;
/// Random stream of the balls that come by themselves.
const STREAM: u32 = 0x5125;
/// Draws of a ball before the robot is put elsewhere.
const DRAWS: usize = 200;

/// A ball in a hand.
#[derive(Clone, Copy, Debug)]
struct Grip {
    at: [f64; 2],
    /// Control steps since the hand last moved.
    silent: u32,
}

/// One scene that any number of visitors play with.
pub(crate) struct Game<'a> {
    subject: &'a Subject,
    arena: Arena,
    engine: u8,
    pub board: Board,
    goal: Goal,
    grip: Option<Grip>,
    playing: Option<Playing>,
    /// Control steps since the last shot was decided.
    idle: u32,
    /// Control steps that the robot has lain.
    down: u32,
    /// Control steps for which it continues without a task.
    awake: u32,
    /// It rested in the last control step.
    rested: bool,
    clip: Option<u16>,
    auto: bool,
    fresh: bool,
    rng: Rng,
    look: u64,
    step: u32,
    /// The ball is in the net.
    netted: bool,
    before: [f64; 3],
}

impl<'a> Game<'a> {
    /// The robot stands at the pitch's origin, the goal is five meters ahead, balls come by themselves.
    pub fn new(subject: &'a Subject, auto: bool, clip: Option<u16>) -> Result<Self, LiveError> {
        let setup = subject.setup.clone();
        let engine = u8::from(matches!(setup.engine, EngineChoice::Mujoco(_)));
        let rng = Rng::new(setup.seed, 0, STREAM);
        let arena = Arena::new(subject, setup)?;
        let mut board = Board::default();
        board.say(if auto { "Automatic balls. Drag the ball to play." } else { "Drag the ball to play." });
        Ok(Self {
            subject,
            arena,
            engine,
            board,
            goal: Goal { center: [5.0, 0.0], heading: 0.0, half_width: GOAL_HALF_WIDTH_M },
            grip: None,
            playing: None,
            idle: 0,
            down: 0,
            awake: 0,
            rested: true,
            clip,
            auto,
            fresh: true,
            rng,
            look: 0,
            step: 0,
            netted: false,
            before: [0.0; 3],
        })
    }

    /// Duration of a control step `[s]`.
    pub fn dt_s(&self) -> f64 {
        self.arena.setup().preset.control_dt_s()
    }

    /// Replaces the policy by another one of the same shape.
    pub fn act_by(&mut self, driver: Box<dyn Driver>) {
        self.arena.act_by(driver);
    }

    fn steps(&self, seconds: f64) -> u32 {
        (seconds / self.dt_s()).round() as u32
    }

    fn seconds(&self, steps: u32) -> f64 {
        f64::from(steps) * self.dt_s()
    }

    /// Does what a visitor wants. Time is not this one's: pause, step and rate change nothing.
    pub fn command(&mut self, command: Command) -> Result<(), LiveError> {
        match command {
            Command::Hold(at) => {
                let at = array(at);
                self.auto = false;
                self.playing = None;
                self.netted = false;
                self.grip = Some(Grip { at, silent: 0 });
                self.arena.put_ball(at, [0.0; 2])?;
            }
            Command::Drop { at, velocity } => self.drop_ball(array(at), array(velocity))?,
            Command::Goal(at) => self.put_goal(array(at))?,
            Command::Push(impulse) => {
                self.awake = self.steps(PUSHED_S);
                self.arena.push(impulse)?;
            }
            Command::Clip(clip) => self.choose(clip),
            Command::Engine(engine) => self.go_to(engine, 0)?,
            // There is nothing to be damped.
            Command::Stop => {}
            Command::Surface(0) => self.go_to(self.engine, 0)?,
            Command::Surface(number) => self.go_to(1, number)?,
            Command::Auto(on) => {
                self.auto = on;
                self.idle = self.steps(PAUSE_S);
            }
            Command::Fresh(on) => self.fresh = on,
            Command::Reset => {
                let ball = self.arena.ball();
                self.playing = None;
                self.stand(&Pose2::default(), [ball[0], ball[1]])?;
            }
            Command::Clear => self.board.clear(),
            Command::Another => self.another()?,
            Command::Pause(_) | Command::Step | Command::Rate(_) => {}
        }
        self.before = self.arena.ball();
        Ok(())
    }

    fn choose(&mut self, clip: Option<u16>) {
        let names = self.arena.setup().library.facts();
        match clip {
            Some(clip) if usize::from(clip) >= names.len() => {
                let words = format!("There are {} clips; there is no number {clip}.", names.len());
                self.board.say(words);
            }
            Some(clip) => {
                let words = format!("Every ball is kicked with the clip {}.", names[usize::from(clip)].name);
                self.clip = Some(clip);
                self.board.say(words);
            }
            None => {
                self.clip = None;
                self.board.say("Every ball is kicked with the clip that fits it best.");
            }
        }
    }

    /// The goal looks to where the robot begins, or to the robot if it is near that.
    fn put_goal(&mut self, at: [f64; 2]) -> Result<(), LiveError> {
        if at[0].hypot(at[1]) > 0.5 {
            self.goal.heading = at[1].atan2(at[0]);
        }
        self.goal.center = at;
        self.arena.put_goal(at)
    }

    fn stand(&mut self, pose: &Pose2, ball: [f64; 2]) -> Result<(), LiveError> {
        self.down = 0;
        self.arena.stand(pose, ball, self.goal.center)
    }

    fn is_down(&self) -> bool {
        let base = &self.arena.sample().bodies[0];
        fallen(base.pos[2], base.rot[2][2], self.arena.setup().spec.nominal_height_m)
    }

    /// The hand lets go.
    fn drop_ball(&mut self, at: [f64; 2], velocity: [f64; 2]) -> Result<(), LiveError> {
        self.grip = None;
        self.auto = false;
        self.netted = false;
        let rolls = velocity[0].hypot(velocity[1]) >= FLICK_M_S;
        let velocity = if rolls { velocity } else { [0.0; 2] };
        let here = self.arena.anchor();
        if !self.is_down() && self.suits(&here, at, velocity) {
            return self.kick(&here, at, velocity);
        }
        if rolls {
            self.playing = None;
            self.board.say("The ball rolls where the robot cannot reach it.");
            return self.arena.put_ball(at, velocity);
        }
        let pose = stance::behind(at, self.goal.center);
        self.board.say("The robot was moved to the ball.");
        self.kick(&pose, at, velocity)
    }

    /// The robot kicks a ball from `pose`.
    fn kick(&mut self, pose: &Pose2, ball: [f64; 2], velocity: [f64; 2]) -> Result<(), LiveError> {
        self.look += 1;
        let place = pose.local(ball);
        let rolling = velocity != [0.0; 2];
        let local = crate::pose2::turned(velocity, -pose.heading);
        let setup = self.arena.setup();
        let motion = match self.clip {
            Some(clip) => usize::from(clip),
            None => Placement::new(setup).motion(0, self.look, place, local),
        };
        let clip = setup.library.facts()[motion].name.clone();
        // Only a standing robot can continue from its present pose.
        let far = (self.arena.anchor().xy[0] - pose.xy[0]).hypot(self.arena.anchor().xy[1] - pose.xy[1]);
        let stance = (self.fresh || self.is_down() || far > 1e-6).then_some(*pose);
        self.arena.kick(&KickPlan {
            motion,
            ball,
            velocity,
            goal: self.goal.center,
            look: self.look,
            stance,
        })?;
        self.down = 0;
        self.netted = false;
        self.before = self.arena.ball();
        self.playing = Some(Playing::new(place, rolling, clip));
        Ok(())
    }

    /// True if the robot at `pose` can kick such a ball at the goal.
    fn suits(&self, pose: &Pose2, ball: [f64; 2], velocity: [f64; 2]) -> bool {
        let setup = self.arena.setup();
        let place = pose.local(ball);
        let local = crate::pose2::turned(velocity, -pose.heading);
        let struck = stance::at_strike(setup, place, local, self.clip.map(usize::from));
        stance::reaches(struck) && stance::faces(pose, self.goal.center) && !self.overlaps(pose, place)
    }

    /// True if the ball would touch the robot.
    fn overlaps(&self, pose: &Pose2, place: [f64; 2]) -> bool {
        if self.fresh {
            let setup = self.arena.setup();
            let placement = Placement::new(setup);
            return placement.overlaps(placement.motion(0, 0, place, [0.0; 2]), place);
        }
        self.arena.touches(self.arena.anchor().local(pose.point(place)))
    }

    /// A ball within reach of the robot's present pose or, if it cannot continue, of a good start.
    fn another(&mut self) -> Result<(), LiveError> {
        self.grip = None;
        let home = stance::home(&self.goal);
        let here = self.arena.anchor();
        // Without fresh starts the robot walks on until it has come too near to the goal.
        let pose = if !self.fresh && !self.is_down() && stance::faces(&here, self.goal.center) {
            here
        } else {
            home
        };
        let Grid { x, y, .. } = Grid::EFFECTIVE;
        for _ in 0..DRAWS {
            let place = [self.rng.uniform(x[0], x[1]), self.rng.uniform(y[0], y[1])];
            let ball = pose.point(place);
            if self.suits(&pose, ball, [0.0; 2]) {
                return self.kick(&pose, ball, [0.0; 2]);
            }
        }
        self.kick(&stance::behind(home.point([1.0, 0.0]), self.goal.center), home.point([1.0, 0.0]), [0.0; 2])
    }

    /// True while nothing happens: no kick, no push, no rolling ball, and no automatic balls.
    fn rests(&self) -> bool {
        let rolls = self.arena.sample().ball_vel.iter().any(|v| v.abs() > ROLLS_M_S);
        self.awake == 0 && self.playing.is_none() && !self.auto && self.down == 0 && !rolls
    }

    /// One control step. Policies are trained to kick and not to wait: they would wander off. So a robot with nothing to do stands in a
    /// clip's last pose, and nothing moves until a command arrives.
    pub fn step(&mut self) -> Result<(), LiveError> {
        self.step = self.step.wrapping_add(1);
        self.awake = self.awake.saturating_sub(1);
        let rests = self.rests();
        if rests && !self.rested && self.grip.is_none() {
            let (here, ball) = (self.arena.anchor(), self.arena.ball());
            self.stand(&here, [ball[0], ball[1]])?;
        }
        self.rested = rests;
        if let Some(grip) = &mut self.grip {
            grip.silent += 1;
            let Grip { at, silent } = *grip;
            if silent > self.steps(GRIP_S) {
                return self.drop_ball(at, [0.0; 2]);
            }
            self.arena.put_ball(at, [0.0; 2])?;
        }
        if rests {
            return Ok(());
        }
        self.arena.step()?;
        if let Some(Grip { at, .. }) = self.grip {
            self.arena.put_ball(at, [0.0; 2])?;
        }
        let ball = self.arena.ball();
        self.judge(ball);
        self.catch(ball)?;
        self.before = ball;
        let was_down = self.down > 0;
        self.down = if self.is_down() { self.down + 1 } else { 0 };
        if self.down > 0 && !was_down {
            self.board.fell();
        }
        self.go_on()
    }

    /// Follows the shot.
    fn judge(&mut self, ball: [f64; 3]) {
        let dt_s = self.dt_s();
        let Some(playing) = &mut self.playing else { return };
        let sample = self.arena.sample();
        let speed = sample.ball_vel.iter().map(|v| v * v).sum::<f64>().sqrt();
        let verdict = playing.follow(&self.goal, sample, self.before, ball, speed, dt_s);
        if let Verdict::Decided(mut shot) = verdict {
            (shot.engine, shot.surface) = (self.engine_name(), ground::name(self.board.surface));
            self.board.count(shot);
            self.playing = None;
            self.idle = 0;
            self.awake = self.steps(PAUSE_S);
        }
    }

    /// The net holds a ball that went in.
    fn catch(&mut self, ball: [f64; 3]) -> Result<(), LiveError> {
        let [past, aside] = self.goal.local([ball[0], ball[1]]);
        let within = aside.abs() < GOAL_HALF_WIDTH_M && ball[2] < GOAL_HEIGHT_M;
        let radius = self.arena.ball_radius_m();
        if self.netted || self.grip.is_some() || !within || past < NET_M - radius || past > NET_M + 0.3 {
            return Ok(());
        }
        self.netted = true;
        let (s, c) = self.goal.heading.sin_cos();
        self.arena.set_ball_velocity([-0.25 * c, -0.25 * s, 0.0])
    }

    /// What comes after a shot or a fall.
    fn go_on(&mut self) -> Result<(), LiveError> {
        if self.playing.is_some() || self.grip.is_some() {
            return Ok(());
        }
        self.idle += 1;
        let lain = self.down > self.steps(DOWN_S);
        if self.auto {
            let ready = self.arena.sample().motion_ended && self.down == 0;
            if (ready && self.idle > self.steps(PAUSE_S)) || lain {
                return self.another();
            }
        } else if lain {
            let here = self.arena.anchor();
            let ball = self.arena.ball();
            self.board.say("The robot was put back on its feet.");
            return self.stand(&here, [ball[0], ball[1]]);
        }
        Ok(())
    }

    /// The scene as it is now. `rate` is asked for and kept.
    pub fn frame(&self, rate: [f32; 2], paused: bool, late: bool, viewers: usize) -> Frame {
        let drawn = self.arena.drawn().frame();
        Frame {
            flags: Flags {
                paused,
                auto: self.auto,
                fallen: self.down > 0,
                late,
                kicking: self.playing.is_some(),
                held: self.grip.is_some(),
                fresh: self.fresh,
                ..drawn.flags
            },
            step: self.step,
            time_s: self.seconds(self.step),
            rate,
            goal: [self.goal.center[0] as f32, self.goal.center[1] as f32, self.goal.heading as f32],
            engine: self.engine,
            viewers: viewers.min(255) as u8,
            clip: self.clip,
            cost_ms: self.arena.cost.as_secs_f32() * 1e3,
            ..drawn
        }
    }
}
