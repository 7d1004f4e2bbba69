//! What comes from the robot, and whether it can be trusted.

use std::sync::Arc;

use super::{Reason, Runtime, State};
use crate::eyes::DeviceClock;
use crate::limits::Limits;
use crate::machine;
use crate::message::{BallDetection, OdometryPose, Packet};
use crate::pause::Silence;
use crate::wire::{LowState, Remote};

/// What the last packets said besides the body.
#[derive(Clone, Debug, Default)]
pub(super) struct Intake {
    pub mode_machine: u8,
    /// When the last state came whose tick was new.
    pub state_us: Option<u64>,
    pub tick: Option<u32>,
    pub silence: Silence,
    /// States so far whose tick was new.
    pub states: u64,
    pub crc_errors: u32,
    /// The last state had a number that is not finite.
    pub not_finite: bool,
    pub remote: Remote,
    pub remote_before: Remote,
    /// Keys of the keyboard in this step.
    pub typed: Remote,
    pub remote_us: u64,
    pub others: bool,
    /// What has failed in this program.
    pub broken: Option<String>,
    pub battery: Option<f64>,
    /// The vendor's controller in command, where the motion switcher was asked; empty: released.
    pub master: Option<String>,
    /// When the last image came, with or without a ball.
    pub picture_us: Option<u64>,
    /// What virtual senses stamp with: over the network the clock of another program.
    pub senses: DeviceClock,
}

impl Intake {
    /// Nothing was received yet.
    pub fn new(limits: &Limits) -> Self {
        Self { silence: Silence::new(limits), ..Self::default() }
    }

    /// The vendor's controller, if it is in command.
    pub fn vendor(&self) -> Option<&str> {
        self.master.as_deref().filter(|name| !name.is_empty())
    }

    /// A stamp of the virtual senses, in what came at `now_us`, on the clock of the runtime `[us]`.
    fn local_us(&mut self, stamp_us: u64, now_us: u64) -> u64 {
        self.senses.local_ns(1000 * stamp_us, 1000 * now_us) / 1000
    }

    /// Time since the last new state `[s]`; infinite before the first.
    pub fn state_age(&self, now_us: u64) -> f64 {
        self.state_us.map_or(f64::INFINITY, |at| now_us.saturating_sub(at) as f64 * 1e-6)
    }

    /// For how long the robot has been silent: the last state's age without a pause of this program `[s]`.
    pub fn silent_s(&self, now_us: u64) -> f64 {
        self.state_us.map_or(f64::INFINITY, |at| self.silence.since_us(at, now_us) as f64 * 1e-6)
    }
}

impl Runtime {
    /// Takes in a packet.
    pub(super) fn take(&mut self, now_us: u64, packet: &Packet) {
        match packet {
            Packet::LowState(bytes) => match LowState::from_cdr(bytes) {
                Ok(state) => self.take_state(now_us, &state),
                Err(_) => self.intake.crc_errors += 1,
            },
            Packet::OthersCommand => self.intake.others = true,
            Packet::Detection(sighting) => {
                self.intake.picture_us = Some(now_us);
                let captured_us = self.intake.local_us(sighting.captured_us, now_us);
                self.world.sighting(BallDetection { captured_us, ..*sighting });
            }
            Packet::Odometry(pose) => {
                let stamp_us = self.intake.local_us(pose.stamp_us, now_us);
                self.world.odometry(OdometryPose { stamp_us, ..*pose });
            }
            Packet::Goal(goal) if goal.iter().all(|x| x.is_finite()) => self.world.goal = Some(*goal),
            Packet::Master(name) => self.intake.master.get_or_insert_default().clone_from(name),
            Packet::Keys(keys) => self.intake.typed.keys |= keys,
            Packet::Battery(percent) if percent.is_finite() => self.intake.battery = Some(*percent),
            Packet::Torso(pose) => {
                if self.world.torso_pose(now_us, pose) {
                    self.lose_sight(now_us);
                }
            }
            Packet::Eyes(report) => {
                let age = report.picture_age_us.map(|age| age.saturating_add(report.age_us));
                self.intake.picture_us = age.map(|age| now_us.saturating_sub(age)).or(self.intake.picture_us);
                self.world.report(now_us, report);
            }
            Packet::GoalAhead(goal) if goal.iter().all(|x| x.is_finite()) => self.world.goal_ahead(*goal),
            Packet::Broken(why) => {
                self.intake.broken.get_or_insert_with(|| why.clone());
            }
            Packet::LowCmd(_) | Packet::Goal(_) | Packet::GoalAhead(_) | Packet::Battery(_) => {}
        }
    }

    fn take_state(&mut self, now_us: u64, state: &LowState) {
        let intake = &mut self.intake;
        if self.limits.check_crc && state.crc != state.expected_crc() {
            intake.crc_errors += 1;
            return;
        }
        self.recognize(now_us, state.mode_machine);
        let intake = &mut self.intake;
        intake.crc_errors = 0;
        intake.mode_machine = state.mode_machine;
        // A state that is sent again says nothing new of the robot.
        if intake.tick != Some(state.tick) {
            intake.tick = Some(state.tick);
            intake.states += 1;
            intake.state_us = Some(now_us);
            intake.silence.heard();
        }
        intake.remote = Remote::new(&state.wireless_remote);
        if intake.remote.present {
            intake.remote_us = now_us;
        }
        intake.not_finite = !self.body.take(state, &self.player);
    }

    /// Takes limits and gains of the robot that reports itself, until its joints are under control.
    fn recognize(&mut self, now_us: u64, mode_machine: u8) {
        if self.state != State::Passive || mode_machine == self.player.mode_machine {
            return;
        }
        let Some(player) = self.robots.iter().find(|player| player.mode_machine == mode_machine) else {
            return;
        };
        self.player = Arc::clone(player);
        if !self.player.is_trained() {
            let robot = machine::words(mode_machine);
            self.note(
                now_us,
                format!("mode_machine {mode_machine}, {robot}: the policy was not trained on it"),
            );
        }
    }

    /// True while it only listens: for a time, until the robot has sent a state, and for good once another program commands a robot that
    /// this runtime has not moved yet. Neither its own damping nor a request to stop lets it take over the robot: it would fight the
    /// program that balances it.
    pub(super) fn listens(&self, now_us: u64) -> bool {
        let begun_us = self.begun_us.unwrap_or(now_us);
        let young = now_us.saturating_sub(begun_us) as f64 * 1e-6 < self.limits.listen_s;
        !self.moved && (young || self.intake.others || self.intake.state_us.is_none())
    }

    /// Why the robot must not stand up now.
    pub(super) fn refusals(&self, now_us: u64) -> Vec<String> {
        let (intake, limits) = (&self.intake, &self.limits);
        let mut out = Vec::new();
        let age = intake.state_age(now_us);
        if age > limits.state_gap_s {
            out.push(Reason::StateGap(age).to_string());
        }
        if intake.crc_errors > 0 {
            out.push(Reason::Checksum(intake.crc_errors).to_string());
        }
        if intake.not_finite {
            out.push(Reason::StateNotFinite.to_string());
        }
        if intake.mode_machine != self.player.mode_machine {
            out.push(Reason::OtherRobot(intake.mode_machine).to_string());
        }
        if self.listens(now_us) && !intake.others {
            out.push("still listening for commands of another program".to_owned());
        }
        if intake.others {
            out.push(Reason::OthersCommand.to_string());
        }
        if let Some(name) = intake.vendor() {
            out.push(Reason::Vendor(name.to_owned()).to_string());
        }
        if self.body.tilt() > limits.start_tilt_rad {
            out.push(Reason::Tilt(self.body.tilt()).to_string());
        }
        if let Some(percent) = intake.battery.filter(|percent| *percent < limits.battery_percent) {
            out.push(Reason::Battery(percent).to_string());
        }
        out
    }

    /// What a kick needs and does not have.
    pub(super) fn missing_senses(&self, now_us: u64) -> Vec<&'static str> {
        let mut out = Vec::new();
        if self.world.odometry_age(now_us) > self.limits.odometry_age_s {
            out.push("no odometry");
        }
        let age = self.intake.picture_us.map_or(u64::MAX, |at| now_us.saturating_sub(at));
        if age as f64 * 1e-6 > self.limits.ball_fresh_s {
            out.push("no ball detector");
        }
        if self.world.goal.is_none() {
            out.push("no goal");
        }
        out
    }
}
