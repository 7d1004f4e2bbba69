//! Robot, senses, link, runtime and writer in step: simulated time waits for all of them, and nothing depends on the machine.

use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use paid_runtime::log::LogWriter;
use paid_runtime::runtime::POLICY_US;
use paid_runtime::wire::{DAMPING_KEYS, Key, Remote};
use paid_runtime::{ChannelLink, Event, Inlet, Limits, Outlet, Packet, Player, Runtime, State, Writer};

use crate::TwinError;
use crate::faults::Fault;
use crate::own_eyes::{OwnEyes, OwnEyesOptions};
use crate::robot::{Mount, VirtualG1};
use crate::senses::{Senses, TrueState};
use crate::serve::Watcher;

/// Time from one pause of the computer to the next ([`LockstepOptions::pause_us`]): two or more in every kick.
const PAUSE_EVERY_US: u64 = 1_300_000;

/// How to set it up.
#[derive(Clone, Debug, Default)]
pub struct LockstepOptions {
    /// Limits of the runtime.
    pub limits: Limits,
    /// Seed of the senses' errors.
    pub seed: u64,
    /// A command takes this long to the robot `[us]`. Default 0; over a network some milliseconds.
    pub command_delay_us: u64,
    /// For this long neither runtime nor writer is run, every 1.3 s, as on a computer that stands still for a moment `[us]`. Default 0.
    pub pause_us: u64,
    /// Onboard perception instead of the virtual senses, which take the ground truth and add random errors.
    pub eyes: Option<OwnEyesOptions>,
    /// Once true, the runtime is asked to stop, as by Ctrl-C.
    pub stop: Arc<AtomicBool>,
}

/// A virtual robot and its runtime.
pub struct Lockstep {
    player: Arc<Player>,
    /// The robot.
    pub robot: VirtualG1,
    /// Its virtual senses, unless it has eyes of its own.
    pub senses: Senses,
    eyes: Option<OwnEyes>,
    runtime: Runtime,
    writer: Writer,
    ends: (ChannelLink, ChannelLink),
    /// Commands on their way, and when they arrive `[us]`.
    on_the_way: VecDeque<(u64, Packet)>,
    command_delay_us: u64,
    pause_us: u64,
    packets: Vec<Packet>,
    events: Vec<Event>,
    fault: Option<Fault>,
    stop: Arc<AtomicBool>,
    begun_us: u64,
    log: Option<LogWriter>,
    peak: [f64; 4],
    listen_s: f64,
    watcher: Option<Box<dyn Watcher>>,
}

impl Lockstep {
    /// A robot on the gantry and a passive runtime.
    ///
    /// # Errors
    /// If MuJoCo is missing.
    pub fn new(player: &Arc<Player>, options: &LockstepOptions) -> Result<Self, TwinError> {
        let robot = VirtualG1::new(Arc::clone(player))?;
        let eyes = options.eyes.as_ref();
        let eyes = eyes.map(|eyes| OwnEyes::new(player, &robot, eyes, options.seed)).transpose()?;
        Ok(Self {
            robot,
            eyes,
            senses: Senses::simulated(&player.play.eyes, player.play.ball_params.radius_m, options.seed),
            runtime: Runtime::new(Arc::clone(player), options.limits.clone()),
            writer: Writer::new(&options.limits, player.joints()),
            ends: ChannelLink::pair(),
            on_the_way: VecDeque::new(),
            command_delay_us: options.command_delay_us,
            pause_us: options.pause_us,
            packets: Vec::new(),
            events: Vec::new(),
            fault: None,
            stop: Arc::clone(&options.stop),
            // The runtime's first step, from which policy steps count.
            begun_us: 2_000,
            log: None,
            peak: [0.0; 4],
            listen_s: options.limits.listen_s,
            watcher: None,
            player: Arc::clone(player),
        })
    }

    /// Writes every step to a log from now on.
    pub fn set_log(&mut self, log: LogWriter) {
        self.log = Some(log);
    }
    /// Who looks on from now on.
    pub fn set_watcher(&mut self, watcher: Box<dyn Watcher>) {
        self.watcher = Some(watcher);
    }
    /// The log, to be finished.
    pub fn take_log(&mut self) -> Option<LogWriter> {
        self.log.take()
    }
    /// The runtime.
    pub fn runtime(&self) -> &Runtime {
        &self.runtime
    }
    /// The player.
    pub fn player(&self) -> &Player {
        &self.player
    }
    /// Everything that the runtime has reported.
    pub fn events(&self) -> &[Event] {
        &self.events
    }
    /// Highest tilt `[rad]`, angular velocity of the pelvis `[rad/s]`, joint speed and torque (shares of their limits) while the policy
    /// moved the robot.
    pub fn peak(&self) -> [f64; 4] {
        self.peak
    }

    /// What is true now.
    pub fn truth(&self) -> TrueState {
        self.robot.true_state()
    }

    /// Injects a fault.
    pub fn inject(&mut self, fault: Fault) {
        self.fault = Some(fault);
        self.robot.set_fault(Some(fault));
        match fault {
            Fault::NoOdometry => self.senses.odometry = false,
            Fault::NoBall => self.senses.ball_visible = false,
            _ => {}
        }
        if let Some(eyes) = &mut self.eyes {
            (eyes.odometry, eyes.open) = (self.senses.odometry, self.senses.ball_visible);
        }
    }

    /// Tells the runtime where the goal is, world (x, y) `[m]`.
    ///
    /// # Errors
    /// If the link fails.
    pub fn place_goal(&mut self, goal: [f64; 2]) -> Result<(), TwinError> {
        let truth = self.truth();
        if let Some(watcher) = &mut self.watcher {
            watcher.goal(goal, truth.torso.rot.yaw());
        }
        let packet = if let Some(eyes) = &mut self.eyes {
            // As the operator gives it: from the torso.
            eyes.place_goal(goal, truth.torso.rot.yaw());
            Packet::GoalAhead(ahead(&truth, goal))
        } else {
            Packet::Goal(self.senses.placed(goal, &truth))
        };
        Ok(self.ends.0.send(packet)?)
    }

    /// Whether ball and torso come from onboard perception.
    pub fn has_own_eyes(&self) -> bool {
        self.eyes.is_some()
    }

    /// How far off the runtime believes the ball to be, seen from its torso `[m]`; not a number while it knows of none.
    pub fn ball_error_m(&self) -> f64 {
        let truth = self.truth();
        let [x, y, _] = truth.ball.0;
        if self.eyes.is_none() {
            let placed = self.senses.placed([x, y], &truth);
            return self.runtime.ball().map_or(f64::NAN, |[bx, by]| (bx - placed[0]).hypot(by - placed[1]));
        }
        let [a, l] = ahead(&truth, [x, y]);
        let believed = self.runtime.status(self.robot.now_us()).ball_m;
        believed.map_or(f64::NAN, |[ba, bl]| (ba - a).hypot(bl - l))
    }

    /// Two milliseconds.
    ///
    /// # Errors
    /// If the link fails.
    pub fn tick(&mut self) -> Result<(), TwinError> {
        self.robot.receive(&mut self.ends.0)?;
        self.robot.step();
        let now_us = self.robot.now_us();
        self.robot.publish(&mut self.ends.0)?;
        let truth = self.truth();
        let mut sent = Ok(());
        let to = &mut self.ends.0;
        let send = |packet| sent = sent.clone().and(to.send(packet));
        match &mut self.eyes {
            Some(eyes) => eyes.step(&self.robot, &self.runtime.phase(), send)?,
            None => self.senses.step(now_us, &truth, send),
        }
        sent?;
        if self.fault == Some(Fault::Kill) {
            return Ok(());
        }
        if now_us % PAUSE_EVERY_US >= self.pause_us {
            self.compute(now_us)?;
        }
        while let Some((_, command)) = self.on_the_way.pop_front_if(|(at_us, _)| *at_us <= now_us) {
            self.ends.1.send(command)?;
        }
        self.show();
        Ok(())
    }

    /// A period of runtime and writer.
    fn compute(&mut self, now_us: u64) -> Result<(), TwinError> {
        while let Some(packet) = self.ends.1.receive()? {
            self.packets.push(packet);
        }
        let stalled = match self.fault {
            Some(Fault::Hang) => true,
            // Called only in the last fifth of each policy period.
            Some(Fault::Late) => (now_us - self.begun_us) % POLICY_US < 16_000,
            _ => false,
        };
        if !stalled {
            let stop = self.fault == Some(Fault::StopSignal) || self.stop.load(Ordering::Relaxed);
            let output = self.runtime.step(now_us, &self.packets, stop);
            if let Some(log) = &mut self.log {
                log.step(now_us, &self.packets, stop, &output, &self.runtime);
            }
            self.packets.clear();
            self.events.extend(output.events);
            self.writer.give(output.command, now_us);
            self.watch();
        }
        if let Some(command) = self.writer.write(now_us) {
            self.on_the_way.push_back((now_us + self.command_delay_us, Packet::LowCmd(command.to_cdr())));
        }
        Ok(())
    }

    /// Shows the step to who looks on.
    fn show(&mut self) {
        let Some(watcher) = &mut self.watcher else { return };
        let now_us = self.robot.now_us();
        if now_us.is_multiple_of(POLICY_US) {
            watcher.status(&self.runtime.status(now_us));
        }
        watcher.step(&self.robot);
        if watcher.stops() {
            self.robot.set_remote(Remote::pressing(&DAMPING_KEYS));
        }
    }

    /// Remembers the highest values while the policy moves the robot.
    fn watch(&mut self) {
        if !matches!(self.runtime.state(), State::Kick | State::Settle) {
            return;
        }
        let state = self.robot.truth();
        let base = &state.bodies[0];
        let share = |values: &[f64], limits: &dyn Fn(usize) -> f64| {
            values.iter().enumerate().fold(0.0_f64, |most, (j, x)| most.max(x.abs() / limits(j)))
        };
        let speed = share(&state.joint_vel, &|j| self.player.control.velocity_limit[j]);
        let torque = share(self.robot.torque(), &|j| self.player.model.joints[j].effort_limit);
        let now = [base.rot.0[2][2].clamp(-1.0, 1.0).acos(), base.ang_vel.norm(), speed, torque];
        for (peak, now) in self.peak.iter_mut().zip(now) {
            *peak = peak.max(now);
        }
    }

    /// Ticks until `done` or for `seconds` of simulated time; true if `done` came.
    ///
    /// # Errors
    /// If the link fails.
    pub fn run_until(
        &mut self,
        seconds: f64,
        mut done: impl FnMut(&Self) -> bool,
    ) -> Result<bool, TwinError> {
        let end_us = self.robot.now_us() + (seconds * 1e6) as u64;
        while self.robot.now_us() < end_us {
            self.tick()?;
            if done(self) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Presses keys of the remote for a tenth of a second.
    ///
    /// # Errors
    /// If the link fails.
    pub fn press(&mut self, keys: &[Key]) -> Result<(), TwinError> {
        self.robot.set_remote(Remote::pressing(keys));
        self.run_until(0.1, |_| false)?;
        self.robot.set_remote(Remote::pressing(&[]));
        self.run_until(0.02, |_| false)?;
        Ok(())
    }

    /// From the gantry to a robot that stands, free if `free`, and is allowed to kick. The goal is 5 m ahead.
    ///
    /// # Errors
    /// If it does not come to that; with the runtime's reasons.
    pub fn make_ready(&mut self, free: bool) -> Result<(), TwinError> {
        self.place_goal([5.0, 0.0])?;
        self.run_until(0.2 + self.listen_s, |_| false)?;
        if self.eyes.is_some() {
            // LiDAR odometry begins from standing, and images come after it.
            self.run_until(1.0, |_| false)?;
            self.place_goal([5.0, 0.0])?;
        }
        self.press(&[Key::L2, Key::Up])?;
        self.run_until(30.0, |s| s.runtime.state() != State::StandUp)?;
        if free {
            self.robot.set_mount(Mount::Free);
            self.run_until(0.5, |_| false)?;
        }
        self.press(&[Key::R1, Key::X])?;
        if matches!(self.runtime.state(), State::Ready | State::Kick) {
            return Ok(());
        }
        let told: Vec<String> = self.events.iter().map(|e| format!("{}: {}", e.to, e.reason)).collect();
        Err(TwinError::refused(told.join("; ")))
    }
}

/// A point of the world (x, y) ahead of the torso and to its left `[m]`.
fn ahead(truth: &TrueState, [x, y]: [f64; 2]) -> [f64; 2] {
    let (s, c) = truth.torso.rot.yaw().sin_cos();
    let [dx, dy] = [x - truth.torso.pos.x(), y - truth.torso.pos.y()];
    [c * dx + s * dy, c * dy - s * dx]
}
