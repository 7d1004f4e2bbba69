//! Who commands the robot, noticed over DDS on the loopback.

use std::net::{IpAddr, Ipv4Addr};
use std::time::{Duration, Instant};

use crate::common::player;
use paid_runtime::ros::RosTopics;
use paid_runtime::wire::{Key, LowCmd, LowState, Remote};
use paid_runtime::{DdsLink, Inlet, Limits, Outlet, Packet, Runtime, Side, State};

const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// Programs on a loopback without multicast find each other after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(90);
const PAUSE: Duration = Duration::from_millis(5);

/// A domain that no other test has. Ports of domains from 101 on are among those that the system hands to others.
fn domain(test: u32) -> u16 {
    20 + ((4 * std::process::id() + test) % 80) as u16
}

#[test]
fn commands_of_another_program_are_noticed_and_own_ones_are_not_taken_for_them() {
    let open = |side| DdsLink::open(domain(1), LOOPBACK, side).expect("the loopback");
    let (mut robot, mut own, mut other) = (open(Side::Robot), open(Side::Runtime), open(Side::Runtime));
    let command = |kd| Packet::LowCmd(LowCmd::damping(5, 29, kd).sealed().to_cdr());
    let begin = Instant::now();
    // First only its own commands, until the robot and the other program have received a hundred of them.
    let (mut heard, mut taken_for_others, mut noticed_by_other) = (0, 0, 0);
    while heard < 100 || noticed_by_other < 100 {
        assert!(begin.elapsed() < PATIENCE, "{heard} heard by the robot, {noticed_by_other} by the other");
        own.send(command(3.0 + heard as f32 * 0.01)).expect("sent");
        std::thread::sleep(PAUSE);
        while let Some(packet) = robot.receive().expect("open") {
            heard += usize::from(matches!(packet, Packet::LowCmd(_)));
        }
        while let Some(packet) = own.receive().expect("open") {
            taken_for_others += usize::from(packet == Packet::OthersCommand);
        }
        while let Some(packet) = other.receive().expect("open") {
            noticed_by_other += usize::from(packet == Packet::OthersCommand);
        }
    }
    assert_eq!(taken_for_others, 0);
    // Then the other program commands, too.
    let mut noticed = false;
    while !noticed {
        assert!(begin.elapsed() < 2 * PATIENCE, "not noticed");
        other.send(command(8.0)).expect("sent");
        std::thread::sleep(PAUSE);
        while let Some(packet) = own.receive().expect("open") {
            noticed |= packet == Packet::OthersCommand;
        }
    }
    // Nor do they hide behind an own command that comes later. A busy machine may lose some.
    let mut rounds = 0;
    for k in 0..20_u8 {
        other.send(command(1.5)).expect("sent");
        std::thread::sleep(PAUSE);
        own.send(command(30.0 + f32::from(k))).expect("sent");
        std::thread::sleep(4 * PAUSE);
        let heard = std::iter::from_fn(|| own.receive().expect("open"));
        rounds += usize::from(heard.filter(|packet| *packet == Packet::OthersCommand).count() > 0);
    }
    assert!(rounds >= 10, "noticed in {rounds} rounds of 20");
}

#[test]
fn the_senses_topic_carries_nothing_but_senses() {
    let mut robot = DdsLink::open(domain(2), LOOPBACK, Side::Robot).expect("the loopback");
    let mut runtime = DdsLink::open(domain(2), LOOPBACK, Side::Runtime).expect("the loopback");
    let begin = Instant::now();
    let mut heard = Vec::new();
    // The goal comes last: once it has come ten times, so has everything before it.
    while heard.iter().filter(|packet| matches!(packet, Packet::Goal(_))).count() < 10 {
        assert!(begin.elapsed() < PATIENCE, "heard {heard:?}");
        let others = [Packet::Keys(0x1020), Packet::Master(String::new()), Packet::Broken("no".to_owned())];
        for packet in others.into_iter().chain([Packet::Goal([5.0, 0.0])]) {
            robot.send(packet).expect("sent");
        }
        std::thread::sleep(PAUSE);
        while let Some(packet) = runtime.receive().expect("open") {
            heard.push(packet);
        }
    }
    assert!(heard.iter().all(|packet| *packet == Packet::Goal([5.0, 0.0])), "{heard:?}");
}

#[test]
fn a_low_battery_is_reported_over_the_wire_and_refused() {
    let mut robot = DdsLink::open(domain(3), LOOPBACK, Side::Robot).expect("the loopback");
    let mut link = DdsLink::open(domain(3), LOOPBACK, Side::Runtime).expect("the loopback");
    // A busy machine is no reason to refuse.
    let limits = Limits { listen_s: 0.0, state_gap_s: 0.1, ..Limits::default() };
    let mut runtime = Runtime::new(player(), limits);
    let begin = Instant::now();
    let (mut told, mut charge) = (Vec::new(), 19.0);
    for tick in 0_u32.. {
        assert!(begin.elapsed() < PATIENCE, "{:?}, told {told:?}", runtime.state());
        let mut state = LowState { mode_machine: 5, tick, ..LowState::default() };
        state.imu.quaternion = [1.0, 0.0, 0.0, 0.0];
        // Pressed again and again.
        let keys: &[Key] = if tick % 20 < 10 { &[Key::L2, Key::Up] } else { &[] };
        state.wireless_remote = Remote::pressing(keys);
        robot.send(Packet::LowState(state.sealed().to_cdr())).expect("sent");
        robot.send(Packet::Battery(charge)).expect("sent");
        std::thread::sleep(PAUSE);
        let packets: Vec<Packet> = std::iter::from_fn(|| link.receive().expect("open")).collect();
        let output = runtime.step(begin.elapsed().as_micros() as u64, &packets, false);
        told.extend(output.events.into_iter().map(|event| event.reason));
        if told.iter().any(|reason| reason.ends_with("battery at 19%")) {
            // Then it is charged to the limit, and stands up.
            charge = 20.0;
        }
        if runtime.state() == State::StandUp {
            break;
        }
    }
    assert_eq!(charge, 20.0, "it stood up with a low battery: {told:?}");
}

#[test]
fn states_of_another_robot_are_told_by_their_type_and_length() {
    let mut link = DdsLink::open(domain(0), LOOPBACK, Side::Runtime).expect("the loopback");
    let mut states = link.state_topic();
    assert_eq!(states.overdue(0), None, "not for long yet");
    // On DDS the topic is rt/lowstate.
    let go2 = RosTopics::open(domain(0), LOOPBACK).expect("the loopback");
    let writer = go2.writer("/lowstate", "unitree_go::msg::dds_::LowState_").expect("a topic");
    let expected = "no state of the robot: rt/lowstate is published as unitree_go::msg::dds_::LowState_, expected \
                    unitree_hg::msg::dds_::LowState_; expected messages of 2088 bytes, found 1180: this program drives a G1 with 29 joints; \
                    a Go2, B2 or H1 sends another LowState_, and so may other firmware";
    let begin = Instant::now();
    while states.why() != expected {
        assert!(begin.elapsed() < PATIENCE, "{}", states.why());
        // Four bytes are the header of CDR.
        writer.send([[0, 1, 0, 0].as_slice(), &[0; 1180]].concat()).expect("sent");
        std::thread::sleep(PAUSE);
        while let Some(packet) = link.receive().expect("open") {
            assert!(matches!(packet, Packet::LowState(_)), "{packet:?}");
        }
    }
    // Once, and not again at once.
    std::thread::sleep(Duration::from_secs(3).saturating_sub(begin.elapsed()));
    assert_eq!(states.overdue(0).as_deref(), Some(expected));
    assert_eq!(states.overdue(0), None);
    assert_eq!(states.overdue(1), None, "a state has come");
}
