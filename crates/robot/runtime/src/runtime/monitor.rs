//! Conditions under which the robot must not continue.

use super::{Reason, Runtime, State};
use crate::limits::Envelope;
use crate::wire::DAMPING_KEYS;

impl Runtime {
    /// The first condition that demands damping.
    pub(super) fn alarm(&self, now_us: u64, stop: bool) -> Option<Reason> {
        if let Some(why) = &self.intake.broken {
            return Some(Reason::Broken(why.clone()));
        }
        if stop {
            return Some(Reason::StopSignal);
        }
        if self.intake.remote.holds(&DAMPING_KEYS) || self.intake.typed.holds(&DAMPING_KEYS) {
            return Some(Reason::StopKey);
        }
        if !self.moves() {
            return None;
        }
        self.link_alarm(now_us).or_else(|| self.body_alarm())
    }

    fn link_alarm(&self, now_us: u64) -> Option<Reason> {
        let (intake, limits) = (&self.intake, &self.limits);
        if intake.crc_errors >= limits.crc_errors {
            return Some(Reason::Checksum(intake.crc_errors));
        }
        let silent_s = intake.silent_s(now_us);
        if silent_s >= limits.state_gap_s {
            return Some(Reason::StateGap(silent_s));
        }
        if intake.not_finite {
            return Some(Reason::StateNotFinite);
        }
        if intake.mode_machine != self.player.mode_machine {
            return Some(Reason::ModeMachine([self.player.mode_machine, intake.mode_machine]));
        }
        if intake.others {
            return Some(Reason::OthersCommand);
        }
        if let Some(name) = intake.vendor() {
            return Some(Reason::Vendor(name.to_owned()));
        }
        let silent = now_us.saturating_sub(intake.remote_us) as f64 * 1e-6;
        if limits.remote_required && silent > limits.remote_s {
            return Some(Reason::RemoteLost(silent));
        }
        None
    }

    /// The wide limits hold from a kick's begin until the robot has settled: the policy's own movement does not end with the clip, and the
    /// peaks that the limits were taken from were measured over both states. A robot that waits has the strict ones, whatever holds its
    /// joints.
    fn envelope(&self) -> &Envelope {
        match self.state {
            State::Kick | State::Settle => &self.limits.kicking,
            State::Passive | State::StandUp | State::Ready | State::Damping => &self.limits.standing,
        }
    }

    fn body_alarm(&self) -> Option<Reason> {
        let (body, limits, envelope) = (&self.body, &self.limits, self.envelope());
        if body.tilt() > envelope.tilt_rad {
            return Some(Reason::Tilt(body.tilt()));
        }
        let gyro = body.base_ang_vel.norm();
        if gyro > envelope.gyro_rad_s {
            return Some(Reason::Gyro(gyro));
        }
        let [(winding, at), (casing, on)] = body.hottest;
        let model = &self.player.model;
        let name = |j: usize| model.joints[j].name.clone();
        if winding >= limits.winding_c {
            return Some(Reason::Winding(name(at), winding));
        }
        if casing >= limits.casing_c {
            return Some(Reason::Casing(name(on), casing));
        }
        for (j, joint) in model.joints.iter().enumerate() {
            let (pos, vel, torque) = (body.joint_pos[j], body.joint_vel[j], body.torque[j]);
            if vel.abs() > envelope.speed_share * self.player.control.velocity_limit[j] {
                return Some(Reason::JointSpeed(name(j), vel));
            }
            if torque.abs() > limits.torque_share * joint.effort_limit {
                return Some(Reason::Torque(name(j), torque));
            }
            let [lo, hi] = joint.range;
            if pos < lo - limits.range_margin_rad || pos > hi + limits.range_margin_rad {
                return Some(Reason::Range(name(j), pos));
            }
        }
        None
    }
}
