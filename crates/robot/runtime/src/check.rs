//! Reads the robot's states for a while and reports on them: rate, clock, checksums, who commands, heat, and which joint moved when and
//! how. Commands nothing.

use std::fmt::Write as _;

use paid_robot::RobotModel;

use crate::limits::Limits;
use crate::machine;
use crate::message::Packet;
use crate::motors::{G1_MOTORS, motors_of};
use crate::wire::{LowState, MotorState};

/// A joint this far from its first angle has been moved `[rad]`: more than what moves along when its neighbor is.
const MOVED_RAD: f64 = 0.15;
/// Joints that begin to move within this time of each other were not moved one at a time `[us]`.
const APART_US: u64 = 200_000;
/// An angle may be this far beyond the joint's range: more is an offset `[rad]`.
const OFFSET_RAD: f64 = 0.1;

/// The robot's clock over this machine's.
const CLOCK: std::ops::RangeInclusive<f64> = 0.95..=1.05;
/// The squared norm of an orientation that is one.
const UNIT_NORM2: std::ops::RangeInclusive<f32> = 0.95..=1.05;

/// A joint's movement since the first state.
#[derive(Clone, Copy, Debug, Default)]
struct Moved {
    first: f64,
    /// Lowest and highest angle less the first `[rad]`.
    range: [f64; 2],
    /// When it was first seen to be moved `[us]`, and in which direction.
    begun: Option<(u64, char)>,
}

impl Moved {
    fn take(&mut self, now_us: u64, angle: f64) {
        let by = angle - self.first;
        self.range = [self.range[0].min(by), self.range[1].max(by)];
        if by.abs() > MOVED_RAD {
            self.begun.get_or_insert((now_us, if by > 0.0 { '+' } else { '-' }));
        }
    }
}

/// Collects states.
#[derive(Clone, Debug, Default)]
pub struct Checker {
    limits: Limits,
    first_us: Option<u64>,
    last_us: u64,
    states: u64,
    bad_crc: u64,
    /// States whose orientation is not a unit quaternion.
    bad_quat: u64,
    bad_length: u64,
    others: u64,
    master: Option<String>,
    without_switcher: bool,
    gaps_ms: Vec<f64>,
    ticks: Option<(u32, u32)>,
    last: Option<LowState>,
    moved: Vec<Moved>,
    /// Highest temperatures of casing and winding in degrees Celsius.
    hottest: [i16; 2],
}

/// What was found.
#[derive(Clone, Debug)]
pub struct CheckReport {
    /// The text for the operator.
    pub text: String,
    /// True if a runtime may start by what was seen.
    pub good: bool,
    /// What was not checked, although nothing contradicts it; empty if nothing is open.
    pub unchecked: String,
}

impl CheckReport {
    /// The last line: good or not, and what it leaves open.
    pub fn verdict(&self) -> String {
        match (self.good, self.unchecked.as_str()) {
            (false, _) => "NOT good: do not start".to_owned(),
            (true, "") => "good".to_owned(),
            (true, open) => format!("good, but {open}"),
        }
    }
}

impl Checker {
    /// For a simulator without motion switcher: the vendor's controller need not be reported released.
    pub fn without_switcher() -> Self {
        Self { without_switcher: true, ..Self::default() }
    }

    /// By these limits: temperatures, and whether states need a checksum (`check_crc`).
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
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
        let norm2: f32 = state.imu.quaternion.iter().map(|q| q * q).sum();
        self.bad_quat += u64::from(!UNIT_NORM2.contains(&norm2));
        if self.first_us.is_some() {
            self.gaps_ms.push((now_us - self.last_us) as f64 * 1e-3);
        }
        self.first_us.get_or_insert(now_us);
        self.last_us = now_us;
        self.states += 1;
        let first = self.ticks.map_or(state.tick, |(first, _)| first);
        self.ticks = Some((first, state.tick));
        if self.moved.is_empty() {
            let first = |motor: &MotorState| Moved { first: f64::from(motor.q), ..Moved::default() };
            self.moved = state.motors[..G1_MOTORS.len()].iter().map(first).collect();
            self.hottest = [i16::MIN; 2];
        }
        for (moved, motor) in self.moved.iter_mut().zip(&state.motors) {
            moved.take(now_us, f64::from(motor.q));
            for (hottest, found) in self.hottest.iter_mut().zip(motor.temperature) {
                *hottest = (*hottest).max(found);
            }
        }
        self.last = Some(state);
    }

    /// Says what was seen.
    pub fn report(&self) -> CheckReport {
        let Some(state) = &self.last else {
            let text = format!("no state came ({} messages of unexpected length)", self.bad_length);
            return CheckReport { text, good: false, unchecked: String::new() };
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
        let _ = writeln!(
            text,
            "clock         the robot's runs at {clock:.4} of this machine's (expected {} to {})",
            CLOCK.start(),
            CLOCK.end()
        );
        let unasked = if self.limits.check_crc { "" } else { " (not asked for: check_crc = false)" };
        let _ = writeln!(
            text,
            "checksums     {crc} wrong{unasked}, {} messages of unexpected length",
            self.bad_length
        );
        let _ = writeln!(
            text,
            "mode_machine  {mode}: {} (expected {}), mode_pr {}",
            machine::words(mode),
            machine::EXPECTED,
            state.mode_pr
        );
        let (released, master) = match &self.master {
            Some(name) if name.is_empty() => (true, "the vendor's controller is released".to_owned()),
            Some(name) => (false, format!("the vendor's controller '{name}' is in command")),
            None => (self.without_switcher, "unknown: the motion switcher has not answered".to_owned()),
        };
        let _ = writeln!(text, "in command    {master}");
        let _ = writeln!(text, "others        {} commands of another program", self.others);
        let tilt = f64::from(state.imu.rpy[0]).hypot(f64::from(state.imu.rpy[1]));
        let _ = writeln!(
            text,
            "pelvis        tilted by {tilt:.3} rad, acceleration {:.2?} m/s^2, {} orientations that are not unit quaternions",
            state.imu.accelerometer, self.bad_quat
        );
        let limits = &self.limits;
        let [casing, winding] = self.hottest;
        let cool = casing < limits.casing_c && winding < limits.winding_c;
        let _ = writeln!(
            text,
            "hottest       winding {winding} of {} degrees, casing {casing} of {}",
            limits.winding_c, limits.casing_c
        );
        let (ordered, order) = self.order();
        let _ = writeln!(text, "joint order   {order}");
        let offsets = offsets(state);
        let said =
            if offsets.is_empty() { "none: every angle is within its joint's range" } else { &offsets };
        let _ = writeln!(text, "offsets       {said}");
        let _ = writeln!(
            text,
            "{:<28} {:>9} {:>8} {:>8} {:>6} {:>8} {:>8}",
            "joint", "angle", "least", "most", "first", "casing", "winding"
        );
        for ((name, motor), moved) in G1_MOTORS.iter().zip(&state.motors).zip(&self.moved) {
            let [casing, winding] = motor.temperature;
            let [least, most] = moved.range;
            let sign = moved.begun.map_or(' ', |(_, sign)| sign);
            let _ = writeln!(
                text,
                "{name:<28} {:>9.3} {least:>8.3} {most:>+8.3} {sign:>6} {casing:>8} {winding:>8}",
                motor.q
            );
        }
        let good = (crc == 0 || !self.limits.check_crc)
            && self.bad_length == 0
            && self.bad_quat == 0
            && CLOCK.contains(&clock)
            && self.others == 0
            && released
            && machine::KNOWN.contains(&mode)
            && gap(1.0) < 20.0
            && cool
            && ordered
            && offsets.is_empty();
        let moved = self.moved.iter().filter(|moved| moved.begun.is_some()).count();
        let unchecked = if moved == G1_MOTORS.len() && !order.starts_with("not known") {
            String::new()
        } else {
            format!("the joint order was not checked in full: {order}")
        };
        CheckReport { text, good, unchecked }
    }

    /// Whether the joints that moved did so in the table's order, and the text about it. Without movement nothing contradicts it.
    fn order(&self) -> (bool, String) {
        let mut moved: Vec<(u64, usize)> =
            self.moved.iter().enumerate().filter_map(|(j, m)| m.begun.map(|(at, _)| (at, j))).collect();
        moved.sort_unstable();
        let (count, all) = (moved.len(), G1_MOTORS.len());
        let mut at_once = None;
        for (k, &(later, b)) in moved.iter().enumerate() {
            // The last one before it first: it is the one that the operator has moved before.
            for &(at, a) in moved[..k].iter().rev() {
                let (one, other) = (G1_MOTORS[a], G1_MOTORS[b]);
                if later - at < APART_US {
                    at_once.get_or_insert((one, other));
                } else if b < a {
                    return (
                        false,
                        format!(
                            "{one} moved before {other}: either they were not moved in the table's order, or the robot's order differs"
                        ),
                    );
                }
            }
        }
        let said = match (at_once, count) {
            (Some((one, other)), _) => {
                format!("not known: {one} and {other} moved at once; move one at a time")
            }
            (None, 0) => "not checked: no joint was moved".to_owned(),
            (None, _) => format!("{count} of {all} joints moved, one after another and in the table's order"),
        };
        (true, said)
    }
}

/// Joints whose angle is beyond their range, which is an offset of the encoder or another joint's angle; empty if there are none.
fn offsets(state: &LowState) -> String {
    let model = RobotModel::g1();
    let motors = motors_of(&model.joint_names()).unwrap_or_default();
    let beyond = model.joints.iter().zip(motors).filter_map(|(joint, motor)| {
        let (angle, [lo, hi]) = (f64::from(state.motors[motor].q), joint.range);
        let within = (lo - OFFSET_RAD..=hi + OFFSET_RAD).contains(&angle);
        (!within).then(|| format!("{} at {angle:.2} rad, its range is {lo:.2} to {hi:.2}", joint.name))
    });
    beyond.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::ImuState;

    /// An upright robot.
    fn sound() -> LowState {
        LowState {
            imu: ImuState { quaternion: [1.0, 0.0, 0.0, 0.0], ..ImuState::default() },
            ..LowState::default()
        }
    }

    #[test]
    fn an_orientation_of_zeros_and_a_slow_clock_are_not_good() {
        let report = moved(&[], |state| state.imu.quaternion = [0.0; 4]);
        assert!(
            !report.good && report.text.contains("250 orientations that are not unit quaternions"),
            "{}",
            report.text
        );
        let report = moved(&[], |state| state.tick /= 150);
        assert!(
            !report.good && report.text.contains("clock         the robot's runs at 0.00"),
            "{}",
            report.text
        );
    }

    #[test]
    fn a_wiggled_joint_shows_under_its_name_and_a_locked_waist_is_not_good() {
        let mut checker = Checker::default();
        for k in 0..100_u32 {
            let mut state = LowState { mode_machine: 5, tick: 2 * k, ..sound() };
            state.motors[14].q = if k == 50 { 0.25 } else { 0.0 };
            checker.take(2000 * u64::from(k), &Packet::LowState(state.sealed().to_cdr()));
        }
        assert!(!checker.report().good, "the vendor's controller was not reported released");
        checker.take(200_000, &Packet::Master("ai".to_owned()));
        let report = checker.report();
        assert!(
            !report.good && report.text.contains("in command    the vendor's controller 'ai' is in command")
        );
        checker.take(200_000, &Packet::Master(String::new()));
        let report = checker.report();
        assert!(report.good, "{}", report.text);
        let line = report.text.lines().find(|l| l.starts_with("waist_pitch_joint")).expect("joint");
        assert!(line.contains("+0.250      +"), "{line}");
        let state = LowState { mode_machine: 6, tick: 200, ..sound() }.sealed();
        checker.take(200_000, &Packet::LowState(state.to_cdr()));
        assert!(!checker.report().good);
    }
    /// A robot whose joints are moved: half a second after the start the first by this much, a second later the next.
    fn moved(joints: &[(usize, f32)], change: impl Fn(&mut LowState)) -> CheckReport {
        let mut checker = Checker::without_switcher();
        for k in 0..250 * (joints.len() as u32 + 1) {
            let mut state = LowState { mode_machine: 5, tick: 4 * k, ..sound() };
            for (i, (motor, by)) in joints.iter().enumerate() {
                // Moved for a tenth of a second.
                let begin = 125 + 250 * i as u32;
                state.motors[*motor].q = if (begin..begin + 25).contains(&k) { *by } else { 0.0 };
            }
            change(&mut state);
            checker.take(4000 * u64::from(k), &Packet::LowState(state.sealed().to_cdr()));
        }
        checker.report()
    }

    #[test]
    fn joints_that_move_in_the_tables_order_are_good_and_others_are_named() {
        let report = moved(&[(0, -0.3), (3, 0.4), (22, 0.2)], |_| {});
        assert!(
            report.good && report.text.contains("3 of 29 joints moved, one after another"),
            "{}",
            report.text
        );
        let row =
            |name: &str| report.text.lines().find(|line| line.starts_with(name)).expect("a row").to_owned();
        assert!(
            row("left_hip_pitch_joint").contains("-0.300   +0.000      -"),
            "{}",
            row("left_hip_pitch_joint")
        );
        let report = moved(&[(3, 0.4), (0, -0.3)], |_| {});
        assert!(!report.good, "{}", report.text);
        assert!(report.text.contains("left_knee_joint moved before left_hip_pitch_joint"), "{}", report.text);
        // A small movement is a neighbor's.
        let report = moved(&[(3, 0.4), (0, -0.1)], |_| {});
        assert!(report.good && report.text.contains("1 of 29 joints moved"), "{}", report.text);
        let unmoved = moved(&[], |_| {});
        assert!(unmoved.text.contains("not checked: no joint was moved"));
        let open = "good, but the joint order was not checked in full: not checked: no joint was moved";
        assert_eq!(unmoved.verdict(), open);
        let all: Vec<(usize, f32)> = (0..29).map(|motor| (motor, 0.2)).collect();
        assert_eq!(moved(&all, |_| {}).verdict(), "good");
    }

    #[test]
    fn a_missing_checksum_is_forgiven_only_where_limits_say_so_and_nothing_else_is() {
        let report = |limits: Limits, mode_machine: u8| {
            let mut checker = Checker::without_switcher().with_limits(limits);
            for k in 0..100_u32 {
                // As the vendor's simulator: no checksum.
                let state = LowState { mode_machine, tick: 2 * k, ..sound() };
                checker.take(2000 * u64::from(k), &Packet::LowState(state.to_cdr()));
            }
            checker.report()
        };
        let without = Limits { check_crc: false, ..Limits::default() };
        assert!(!report(Limits::default(), 5).good);
        let forgiven = report(without.clone(), 5);
        assert!(forgiven.good && forgiven.text.contains("100 wrong (not asked for"), "{}", forgiven.text);
        assert!(!report(without, 6).good);
    }

    #[test]
    fn two_joints_at_once_say_nothing_of_the_order() {
        let report = moved(&[(5, 0.3)], |state| state.motors[4].q = state.motors[5].q);
        assert!(report.good && report.text.contains("moved at once; move one at a time"), "{}", report.text);
    }

    #[test]
    fn two_joints_at_once_hide_no_joint_that_moved_too_late() {
        let at_once = |state: &mut LowState| state.motors[4].q = state.motors[5].q;
        let report = moved(&[(5, 0.3), (2, 0.3)], at_once);
        assert!(!report.good, "{}", report.text);
        let expected = "left_ankle_roll_joint moved before left_hip_yaw_joint";
        assert!(report.text.contains(expected), "{}", report.text);
        let report = moved(&[(5, 0.3), (6, 0.3)], at_once);
        assert!(report.good && report.text.contains("moved at once; move one at a time"), "{}", report.text);
    }

    #[test]
    fn heat_and_an_angle_beyond_the_range_are_not_good() {
        let report = moved(&[], |state| state.motors[7].temperature = [60, 120]);
        assert!(!report.good && report.text.contains("winding 120 of 120 degrees"), "{}", report.text);
        // The knee's range begins at -0.087 rad.
        let report = moved(&[], |state| state.motors[3].q = -0.25);
        assert!(!report.good, "{}", report.text);
        assert!(
            report.text.contains("left_knee_joint at -0.25 rad, its range is -0.09 to 2.88"),
            "{}",
            report.text
        );
    }
}
