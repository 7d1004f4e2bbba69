//! Reads the robot's states for a while and says what they are like. Commands nothing.

use std::fmt::Write as _;

use crate::message::Packet;
use crate::motors::G1_MOTORS;
use crate::wire::{LowState, MODE_MACHINE_G1_29};

/// Collects states.
#[derive(Clone, Debug, Default)]
pub struct Checker {
    first_us: Option<u64>,
    last_us: u64,
    states: u64,
    bad_crc: u64,
    bad_length: u64,
    others: u64,
    master: Option<String>,
    without_switcher: bool,
    gaps_ms: Vec<f64>,
    ticks: Option<(u32, u32)>,
    last: Option<LowState>,
    range: Vec<[f32; 2]>,
}

/// What was found.
#[derive(Clone, Debug)]
pub struct CheckReport {
    /// The text for the operator.
    pub text: String,
    /// True if a runtime may start by what was seen.
    pub good: bool,
}

impl Checker {
    /// For a simulator without motion switcher: nobody has to say that the vendor's controller is released.
    pub fn without_switcher() -> Self {
        Self { without_switcher: true, ..Self::default() }
    }

    /// Takes in a packet that came at `now_us` `[us]`.
    pub fn take(&mut self, now_us: u64, packet: &Packet) {
        let bytes = match packet {
            Packet::LowState(bytes) => bytes,
            Packet::OthersCommand => {
                self.others += 1;
                return;
            }
            Packet::Master(name) => {
                self.master = Some(name.clone());
                return;
            }
            _ => return,
        };
        let Ok(state) = LowState::from_cdr(bytes) else {
            self.bad_length += 1;
            return;
        };
        self.bad_crc += u64::from(state.crc != state.expected_crc());
        if self.first_us.is_some() {
            self.gaps_ms.push((now_us - self.last_us) as f64 * 1e-3);
        }
        self.first_us.get_or_insert(now_us);
        self.last_us = now_us;
        self.states += 1;
        let first = self.ticks.map_or(state.tick, |(first, _)| first);
        self.ticks = Some((first, state.tick));
        self.range.resize(G1_MOTORS.len(), [f32::INFINITY, f32::NEG_INFINITY]);
        for (range, motor) in self.range.iter_mut().zip(&state.motors) {
            *range = [range[0].min(motor.q), range[1].max(motor.q)];
        }
        self.last = Some(state);
    }

    /// Says what was seen.
    pub fn report(&self) -> CheckReport {
        let Some(state) = &self.last else {
            let text = format!("no state came ({} messages of another length)", self.bad_length);
            return CheckReport { text, good: false };
        };
        let seconds = (self.last_us - self.first_us.unwrap_or(0)) as f64 * 1e-6;
        let mut gaps = self.gaps_ms.clone();
        gaps.sort_by(f64::total_cmp);
        let gap = |share: f64| gaps.get(((gaps.len() as f64 * share) as usize).min(gaps.len().max(1) - 1));
        let gap = |share: f64| gap(share).copied().unwrap_or(f64::NAN);
        let (first, last) = self.ticks.unwrap_or_default();
        let clock = f64::from(last.wrapping_sub(first)) * 1e-3 / seconds.max(1e-9);
        let (crc, mode) = (self.bad_crc, state.mode_machine);
        let mut text = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "states        {} in {seconds:.1} s, {:.0} a second",
            self.states,
            self.states as f64 / seconds.max(1e-9)
        );
        let _ = writeln!(
            text,
            "gaps          median {:.2} ms, 99.9% {:.2} ms, longest {:.2} ms",
            gap(0.5),
            gap(0.999),
            gap(1.0)
        );
        let _ = writeln!(text, "clock         the robot's runs at {clock:.4} of this machine's");
        let _ = writeln!(text, "checksums     {crc} wrong, {} messages of another length", self.bad_length);
        let _ = writeln!(
            text,
            "mode_machine  {mode} (expected {MODE_MACHINE_G1_29}: 29 free joints), mode_pr {}",
            state.mode_pr
        );
        let (released, master) = match &self.master {
            Some(name) if name.is_empty() => (true, "the vendor's controller is released".to_owned()),
            Some(name) => (false, format!("the vendor's controller '{name}' is in command")),
            None => (self.without_switcher, "unknown: the motion switcher has not answered".to_owned()),
        };
        let _ = writeln!(text, "in command    {master}");
        let _ = writeln!(text, "others        {} commands of somebody else", self.others);
        let tilt = f64::from(state.imu.rpy[0]).hypot(f64::from(state.imu.rpy[1]));
        let _ = writeln!(
            text,
            "pelvis        tilted by {tilt:.3} rad, acceleration {:.2?} m/s^2",
            state.imu.accelerometer
        );
        let _ =
            writeln!(text, "{:<28} {:>9} {:>9} {:>8} {:>8}", "joint", "angle", "moved", "casing", "winding");
        for ((name, motor), [lo, hi]) in G1_MOTORS.iter().zip(&state.motors).zip(&self.range) {
            let [casing, winding] = motor.temperature;
            let _ = writeln!(text, "{name:<28} {:>9.3} {:>9.3} {casing:>8} {winding:>8}", motor.q, hi - lo);
        }
        let good = crc == 0
            && self.bad_length == 0
            && self.others == 0
            && released
            && mode == MODE_MACHINE_G1_29
            && gap(1.0) < 20.0;
        CheckReport { text, good }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wiggled_joint_shows_under_its_name_and_a_locked_waist_is_not_good() {
        let mut checker = Checker::default();
        for k in 0..100_u32 {
            let mut state = LowState { mode_machine: 5, tick: 2 * k, ..LowState::default() };
            state.motors[14].q = if k == 50 { 0.25 } else { 0.0 };
            checker.take(2000 * u64::from(k), &Packet::LowState(state.sealed().to_cdr()));
        }
        assert!(!checker.report().good, "nobody has said that the vendor's controller is released");
        checker.take(200_000, &Packet::Master("ai".to_owned()));
        let report = checker.report();
        assert!(
            !report.good && report.text.contains("in command    the vendor's controller 'ai' is in command")
        );
        checker.take(200_000, &Packet::Master(String::new()));
        let report = checker.report();
        assert!(report.good, "{}", report.text);
        let line = report.text.lines().find(|l| l.starts_with("waist_pitch_joint")).expect("joint");
        assert!(line.contains("0.250"), "{line}");
        let state = LowState { mode_machine: 6, ..LowState::default() }.sealed();
        checker.take(200_000, &Packet::LowState(state.to_cdr()));
        assert!(!checker.report().good);
    }
}
