//! Each limit from both sides: a value just inside does nothing, one just outside damps.

use std::sync::Arc;

use crate::common::player;
use paid_runtime::wire::{Key, LowState, Remote};
use paid_runtime::{Limits, Packet, Player, Runtime, State};

/// The state in which something happens for the first time: the robot has stood since the 20th.
const BEGIN: u64 = 50;

/// The robot's message in state `k`; none: nothing comes.
type Course<'a> = &'a dyn Fn(u64, LowState) -> Option<LowState>;

/// A robot that stands, in a hundred steps at these times `[us]`: its last state, and why it damps.
fn stand(player: &Arc<Player>, at_us: impl Fn(u64) -> u64, course: Course<'_>) -> (State, String) {
    let limits = Limits { stand_up_s: 0.01, listen_s: 0.0, ..Limits::default() };
    let mut runtime = Runtime::new(Arc::clone(player), limits);
    for k in 1..=100_u64 {
        let mut state = LowState { mode_machine: 5, tick: 2 * k as u32, ..LowState::default() };
        state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
        let keys: &[Key] = if k == 3 { &[Key::L2, Key::Up] } else { &[] };
        state.wireless_remote = Remote::pressing(keys);
        let told = course(k, state).map(|state| Packet::LowState(state.to_cdr()));
        let packets: Vec<Packet> = told.into_iter().collect();
        runtime.step(at_us(k), &packets, false);
        assert!(k != BEGIN - 1 || runtime.state() == State::Ready, "{:?}", runtime.why());
    }
    (runtime.state(), runtime.why().map(ToString::to_string).unwrap_or_default())
}

/// The same with a step every 2 ms and a change to every state from `BEGIN` on.
fn with(player: &Arc<Player>, change: impl Fn(&mut LowState)) -> (State, String) {
    stand(player, |k| 2000 * k, &|k, mut state| {
        if k >= BEGIN {
            change(&mut state);
        }
        Some(state.sealed())
    })
}

/// A change that is harmless, one that is not, and the text for it.
type Pair<'a> = (&'a dyn Fn(&mut LowState), &'a dyn Fn(&mut LowState), &'a str);

#[test]
fn the_body_may_come_as_near_to_a_limit_as_it_likes() {
    let player = player();
    let limits = Limits::default();
    let tilted = |rad: f64| {
        let (sin, cos) = (0.5 * rad).sin_cos();
        move |state: &mut LowState| state.imu.quaternion = [cos as f32, 0.0, sin as f32, 0.0]
    };
    let turning = |rad_s: f64| move |state: &mut LowState| state.imu.gyroscope[1] = rad_s as f32;
    // The left knee is motor 3 and joint 3.
    let knee = &player.model.joints[3];
    let speed = limits.standing.speed_share * player.control.velocity_limit[3];
    let fast = |rad_s: f64| move |state: &mut LowState| state.motors[3].dq = rad_s as f32;
    let torque = limits.torque_share * knee.effort_limit;
    let strained = |n_m: f64| move |state: &mut LowState| state.motors[3].tau_est = n_m as f32;
    let [low, high] = [knee.range[0] - limits.range_margin_rad, knee.range[1] + limits.range_margin_rad];
    let bent = |rad: f64| move |state: &mut LowState| state.motors[3].q = rad as f32;
    let hot = |winding: i16| move |state: &mut LowState| state.motors[3].temperature = [20, winding];
    let warm = |casing: i16| move |state: &mut LowState| state.motors[3].temperature = [casing, 20];
    let cases: [Pair<'_>; 9] = [
        (&tilted(0.99), &tilted(1.01), "tilted by 1.01 rad"),
        (&turning(5.99), &turning(6.01), "turning at 6.0 rad/s"),
        (&fast(speed - 0.01), &fast(speed + 0.01), "left_knee_joint at"),
        (&fast(0.01 - speed), &fast(-speed - 0.01), "left_knee_joint at -"),
        (&strained(torque - 0.1), &strained(torque + 0.1), "left_knee_joint with"),
        (&bent(low + 0.001), &bent(low - 0.001), "beyond its range"),
        (&bent(high - 0.001), &bent(high + 0.001), "beyond its range"),
        (&hot(119), &hot(120), "winding of left_knee_joint at 120 degrees"),
        (&warm(84), &warm(85), "casing of left_knee_joint at 85 degrees"),
    ];
    for (inside, outside, why) in cases {
        assert_eq!(with(&player, inside), (State::Ready, String::new()), "just inside: {why}");
        let (state, told) = with(&player, outside);
        assert!(state == State::Damping && told.contains(why), "just outside: {why}: {state} {told}");
    }
}

#[test]
fn two_wrong_checksums_are_forgiven_and_three_are_not() {
    let player = player();
    let wrong = |count: u64| {
        stand(&player, |k| 2000 * k, &move |k, state| {
            let mut state = state.sealed();
            if (BEGIN..BEGIN + count).contains(&k) {
                state.crc ^= 1;
            }
            Some(state)
        })
    };
    assert_eq!(wrong(2), (State::Ready, String::new()));
    assert_eq!(wrong(3), (State::Damping, "3 wrong checksums in a row".to_owned()));
}

#[test]
fn a_gap_of_eighteen_milliseconds_is_forgiven_and_one_of_twenty_is_not() {
    let player = player();
    // States are missing; the last one before the gap is as old as the gap when the next comes.
    let missing = |count: u64| {
        stand(&player, |k| 2000 * k, &move |k, state| {
            (!(BEGIN..BEGIN + count).contains(&k)).then(|| state.sealed())
        })
    };
    assert_eq!(missing(9), (State::Ready, String::new()));
    assert_eq!(missing(10), (State::Damping, "no new state for 20 ms".to_owned()));
    // A state that is sent again is none.
    let repeated = |count: u64| {
        stand(&player, |k| 2000 * k, &move |k, mut state| {
            if (BEGIN..BEGIN + count).contains(&k) {
                state.tick = 2 * (BEGIN as u32 - 1);
            }
            Some(state.sealed())
        })
    };
    assert_eq!(repeated(9), (State::Ready, String::new()));
    assert_eq!(repeated(10), (State::Damping, "no new state for 20 ms".to_owned()));
}

#[test]
fn a_short_pause_of_the_computer_is_no_gap() {
    let player = player();
    // Nothing is run for a time, and in the first step after it no state is there yet.
    let paused = |pause_us: u64| {
        let at = move |k: u64| 2000 * k + if k >= BEGIN { pause_us } else { 0 };
        stand(&player, at, &|k, state| (k != BEGIN).then(|| state.sealed()))
    };
    assert_eq!(paused(25_000), (State::Ready, String::new()));
    assert_eq!(paused(60_000), (State::Damping, "no new state for 62 ms".to_owned()));
}

#[test]
fn one_late_policy_step_is_forgiven_and_two_are_not() {
    let player = player();
    // Every tenth step of 2 ms is a policy step, the 51st among them. Starting with it, `times` policy steps in a row come late.
    let late = |late_us: u64, count: u64| {
        let at = move |k: u64| match k.checked_sub(51) {
            None => 2000 * k,
            Some(i) if i < count => 102_000 + 20_000 * i + late_us,
            Some(i) => 102_000 + 20_000 * count + 2000 * (i - count),
        };
        stand(&player, at, &|_, state| Some(state.sealed()))
    };
    assert_eq!(late(12_000, 1), (State::Ready, String::new()));
    assert_eq!(late(8_000, 3), (State::Ready, String::new()));
    let (state, told) = late(12_000, 2);
    assert!(state == State::Damping && told.starts_with("policy steps late"), "{state} {told}");
}

#[test]
fn a_remote_may_be_silent_for_less_than_half_a_second() {
    let player = player();
    let silent = |step_us: u64| {
        let at = move |k: u64| if k < BEGIN { 2000 * k } else { 2000 * BEGIN + step_us * (k - BEGIN) };
        stand(&player, at, &|k, mut state| {
            if k >= BEGIN {
                state.wireless_remote = [0; 40];
            }
            Some(state.sealed())
        })
    };
    // The remote last spoke 2 ms before `BEGIN`; 50 steps of 9.9 and 10 ms follow.
    assert_eq!(silent(9_900), (State::Ready, String::new()));
    let (state, told) = silent(10_000);
    assert!(state == State::Damping && told.starts_with("the remote has been silent"), "{state} {told}");
}
