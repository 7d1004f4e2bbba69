//! The runtime: packets in, a command out, 500 times a second. No threads, no clock of its own: the same packets at the same times
//! give the same commands bit for bit.

mod act;
mod body;
mod intake;
mod latency;
mod monitor;
mod phase;
mod reason;
mod status;
mod world;

use std::sync::Arc;

use paid_policy::{PolicyState, SceneView};
use serde::{Deserialize, Serialize};

use crate::limits::Limits;
use crate::message::Packet;
use crate::player::Player;
use crate::wire::{Key, LowCmd};
use body::Body;
use intake::Intake;
use world::WorldBelief;

pub use latency::{Latency, LatencyFigures};
pub use phase::Phase;
pub use reason::{Event, Reason, State};
pub use status::{JointStatus, Status};

/// Time between two policy steps `[us]`.
pub const POLICY_US: u64 = 20_000;

/// What the policy got and gave in one step.
#[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PolicyTrace {
    /// The observation, as the contract lists it, as the policy sees it: mirrored in a kick that it plays in the mirror.
    pub observation: Vec<f32>,
    /// The action, policy joint order, as the policy gives it.
    pub action: Vec<f32>,
}

/// A copy into one that has room allocates nothing.
impl Clone for PolicyTrace {
    fn clone(&self) -> Self {
        Self { observation: self.observation.clone(), action: self.action.clone() }
    }
    fn clone_from(&mut self, other: &Self) {
        self.observation.clone_from(&other.observation);
        self.action.clone_from(&other.action);
    }
}

/// What a step of the runtime gives.
#[derive(Clone, Debug)]
pub struct Output {
    /// The command, with its checksum; nothing while the runtime listens for another program's commands.
    pub command: Option<LowCmd>,
    /// The state after the step.
    pub state: State,
    /// True if the policy has acted: [`Runtime::trace`] is its step.
    pub acted: bool,
    /// What has happened.
    pub events: Vec<Event>,
}

/// Who moves the joints.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Controller {
    Damping,
    Standing,
    Policy,
}

/// A kick that has begun.
#[derive(Clone, Debug)]
struct Playing {
    motion: usize,
    /// Policy steps since its begin.
    step: usize,
    /// Ball and goal as last shown.
    shown: Option<SceneView<f64>>,
    /// True once it continues without odometry, or once odometry has begun a new frame: what was shown last is shown until the next kick.
    blind: bool,
    /// True once it was reported that the ball was not seen for too long.
    unseen: bool,
}

/// See the module.
pub struct Runtime {
    /// The player of the robot that reports itself; the first one until it does.
    player: Arc<Player>,
    /// The same of all robots that it may be.
    robots: Vec<Arc<Player>>,
    limits: Limits,
    state: State,
    begun_us: Option<u64>,
    /// True once it has moved the joints. The robot is its own after that.
    moved: bool,
    entered_us: u64,
    body: Body,
    intake: Intake,
    world: WorldBelief,
    enabled: bool,
    controller: Controller,
    switched_us: u64,
    /// How fast targets may move after it `[rad/s]`.
    switch_rad_s: f64,
    /// Joint targets, model order `[rad]`: what the controller wants, and where the rate limit has got to.
    wanted: Vec<f64>,
    limited: Vec<f64>,
    ramp_from: Vec<f64>,
    playing: Option<Playing>,
    memory: PolicyState,
    trace: PolicyTrace,
    /// The last action as the world got it: the policy's, out of the mirror.
    done: Vec<f32>,
    /// Room for the policy's step, which must not allocate.
    joints: Vec<f64>,
    numbers: Vec<f64>,
    image: Vec<f32>,
    next_policy_us: Option<u64>,
    late: u32,
    still_since_us: Option<u64>,
    why: Option<Reason>,
    waiting: &'static str,
    events: Vec<Event>,
    kicks: usize,
    phase: Arc<Phase>,
    latency: Latency,
}

impl Runtime {
    /// A passive runtime.
    pub fn new(player: Arc<Player>, limits: Limits) -> Self {
        let joints = player.joints();
        let zeros = vec![0.0; joints];
        let others = player.spec.mode_machines.iter().filter(|&&mode| mode != player.mode_machine);
        let mut robots: Vec<_> =
            others.filter_map(|&mode| player.as_variant(mode).ok()).map(Arc::new).collect();
        robots.push(Arc::clone(&player));
        Self {
            body: Body::new(joints),
            intake: Intake::new(&limits),
            world: WorldBelief::new(&player),
            memory: player.policy.start(1),
            trace: PolicyTrace {
                observation: Vec::with_capacity(player.policy.obs_dim()),
                action: vec![0.0; joints],
            },
            done: vec![0.0; joints],
            numbers: Vec::with_capacity(player.policy.obs_dim()),
            image: Vec::with_capacity(player.policy.obs_dim().max(joints)),
            player,
            robots,
            limits,
            state: State::Passive,
            begun_us: None,
            moved: false,
            entered_us: 0,
            enabled: false,
            controller: Controller::Damping,
            switched_us: 0,
            switch_rad_s: 0.0,
            wanted: zeros.clone(),
            limited: zeros.clone(),
            ramp_from: zeros,
            playing: None,
            joints: Vec::with_capacity(2 * joints),
            next_policy_us: None,
            late: 0,
            still_since_us: None,
            why: None,
            waiting: "",
            events: Vec::new(),
            kicks: 0,
            phase: Arc::default(),
            latency: Latency::default(),
        }
    }

    /// When the foot strikes, for eyes in another thread: a strike may send the ball anywhere.
    pub fn phase(&self) -> Arc<Phase> {
        Arc::clone(&self.phase)
    }
    /// From the capture of each image of the ball to the first joint targets that it affects.
    pub fn latency(&self) -> &Latency {
        &self.latency
    }

    /// The player.
    pub fn player(&self) -> &Player {
        &self.player
    }
    /// The state.
    pub fn state(&self) -> State {
        self.state
    }
    /// Its limits.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }
    /// Why it damps, if it does.
    pub fn why(&self) -> Option<&Reason> {
        self.why.as_ref()
    }
    /// What a robot that is ready waits for; empty if for nothing.
    pub fn waiting(&self) -> &'static str {
        self.waiting
    }
    /// Kicks that have begun.
    pub fn kicks(&self) -> usize {
        self.kicks
    }
    /// What the policy got and gave last.
    pub fn trace(&self) -> &PolicyTrace {
        &self.trace
    }
    /// Motion of the kick that is played or was the last one.
    pub fn motion(&self) -> Option<usize> {
        self.playing.as_ref().map(|playing| playing.motion)
    }
    /// Where the ball is estimated to be (x, y), odometry's frame `[m]`.
    pub fn ball(&self) -> Option<[f64; 2]> {
        let belief = self.world.belief(f64::INFINITY);
        belief.known.then_some(belief.ball.position)
    }

    /// A step at `now_us` `[us]`, with what has come since the last one. `stop` is true once the operator has asked the program to end.
    pub fn step(&mut self, now_us: u64, packets: &[Packet], stop: bool) -> Output {
        self.intake.silence.step(now_us);
        // The body first: a pose of odometry is held against the inertial sensor's heading of the same time.
        let of_body = |packet: &&Packet| matches!(packet, Packet::LowState(_));
        for packet in packets.iter().filter(of_body) {
            self.take(now_us, packet);
        }
        self.world.remember(now_us, &self.body, &self.player);
        for packet in packets.iter().filter(|packet| !of_body(packet)) {
            self.take(now_us, packet);
        }
        let policy_due = self.policy_due(now_us);
        if self.state != State::Damping {
            if let Some(reason) = self.alarm(now_us, stop) {
                self.damp(now_us, reason);
            } else {
                self.keys(now_us);
            }
        }
        self.intake.typed.keys = 0;
        let mut acted = false;
        if policy_due {
            self.world.advance(now_us, POLICY_US as f64 * 1e-6, self.to_strike());
            acted = self.think(now_us);
            self.phase.set(self.to_strike());
            if acted {
                self.latency.acted(now_us, self.world.belief(self.to_strike()).age_s);
            }
        }
        if self.state == State::StandUp {
            self.stand_up(now_us);
        }
        self.begun_us.get_or_insert(now_us);
        let command = (!self.listens(now_us)).then(|| self.command(now_us));
        Output { command, state: self.state, acted, events: std::mem::take(&mut self.events) }
    }

    /// True where a policy step is due; counts those that came late.
    fn policy_due(&mut self, now_us: u64) -> bool {
        let due = *self.next_policy_us.get_or_insert(now_us);
        if now_us < due {
            return false;
        }
        let late_s = (now_us - due) as f64 * 1e-6;
        self.late = if late_s > self.limits.late_s { self.late + 1 } else { 0 };
        if self.late >= self.limits.late_steps && self.moves() {
            self.damp(now_us, Reason::Late(late_s));
        }
        // A late step does not make the next one early.
        let next = due + POLICY_US;
        self.next_policy_us = Some(if next <= now_us { now_us + POLICY_US } else { next });
        true
    }

    /// True while joints are under control.
    fn moves(&self) -> bool {
        !matches!(self.state, State::Passive | State::Damping)
    }

    /// Time until the motion strikes `[s]`; infinite while none is played, negative after the strike.
    fn to_strike(&self) -> f64 {
        match &self.playing {
            Some(playing) if self.state != State::Ready => {
                let facts = &self.player.library.facts()[playing.motion];
                facts.times_from(playing.step, POLICY_US as f64 * 1e-6).to_strike_s
            }
            _ => f64::INFINITY,
        }
    }

    fn enter(&mut self, now_us: u64, state: State, reason: impl Into<String>) {
        self.events.push(Event { at_us: now_us, from: self.state, to: state, reason: reason.into() });
        self.state = state;
        if state == State::Ready {
            self.phase.look_again();
        }
        self.entered_us = now_us;
        self.still_since_us = None;
    }

    /// Writes a line without a change of state.
    fn note(&mut self, now_us: u64, text: impl Into<String>) {
        self.events.push(Event { at_us: now_us, from: self.state, to: self.state, reason: text.into() });
    }

    fn damp(&mut self, now_us: u64, reason: Reason) {
        if self.state == State::Damping {
            return;
        }
        self.enter(now_us, State::Damping, reason.to_string());
        self.why = Some(reason);
        self.playing = None;
        self.controller = Controller::Damping;
    }

    /// Another controller takes over: targets begin at the measured pose.
    fn switch(&mut self, now_us: u64, controller: Controller) {
        if self.controller != controller {
            self.moved = true;
            self.controller = controller;
            self.switched_us = now_us;
            self.switch_rad_s = self.limits.switch_rad_s;
            self.limited.copy_from_slice(&self.body.joint_pos);
        }
    }

    /// The remote's keys.
    fn keys(&mut self, now_us: u64) {
        let intake = &self.intake;
        let pressed = |keys: &[Key]| {
            intake.typed.holds(keys) || intake.remote.holds(keys) && !intake.remote_before.holds(keys)
        };
        let (up, play) = (pressed(&[Key::L2, Key::Up]), pressed(&[Key::R1, Key::X]));
        if up && self.state == State::Passive {
            let refusals = self.refusals(now_us);
            if refusals.is_empty() {
                self.begin_to_stand(now_us, "keys L2 and up");
            } else {
                self.note(now_us, format!("refused to stand up: {}", refusals.join("; ")));
            }
        }
        if play && self.state == State::Ready {
            let missing = self.missing_senses(now_us);
            if missing.is_empty() {
                // It may have become ready in the air, and stands on the floor by now.
                if !self.enabled {
                    self.phase.look_again();
                }
                self.enabled = true;
                self.note(now_us, "keys R1 and X: kicks are allowed");
            } else {
                self.note(now_us, format!("refused to kick: {}", missing.join("; ")));
            }
        }
        self.intake.remote_before = self.intake.remote;
    }

    fn begin_to_stand(&mut self, now_us: u64, reason: &str) {
        self.ramp_from.copy_from_slice(&self.body.joint_pos);
        self.playing = None;
        self.switch(now_us, Controller::Standing);
        self.enter(now_us, State::StandUp, reason);
    }

    /// The ramp to the standing pose.
    fn stand_up(&mut self, now_us: u64) {
        let share = (now_us - self.entered_us) as f64 * 1e-6 / self.limits.stand_up_s;
        let smooth = |x: f64| x * x * (3.0 - 2.0 * x);
        let share = smooth(share.min(1.0));
        for (j, wanted) in self.wanted.iter_mut().enumerate() {
            let (from, to) = (self.ramp_from[j], self.player.control.default_pos[j]);
            *wanted = from + share * (to - from);
        }
        if share >= 1.0 {
            self.enter(now_us, State::Ready, "the standing pose is reached");
        }
    }
}
