//! The robot's own programs at the other end of the wire: CycloneDDS 0.10.2, and the vendor's SDKs on it. `.ci/peers` installs them.

use std::io::{BufRead, BufReader};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::common::player;
use paid_runtime::switcher::{Patience, SwitcherClient, SwitcherService, await_release};
use paid_runtime::wire::{BmsState, LowCmd, LowState};
use paid_runtime::{
    DdsLink, Inlet, LastWords, Limits, Live, Outlet, Packet, Runtime, Side, State, Writer, run_live,
};
use paid_twin::{ServeOptions, VendorLink, serve};

const LOOPBACK: IpAddr = IpAddr::V4(Ipv4Addr::LOCALHOST);
/// The loopback has no multicast: single addresses instead.
const ON_LOOPBACK: &str = r#"<CycloneDDS><Domain Id="any"><General><AllowMulticast>false</AllowMulticast><Interfaces>
<NetworkInterface name="lo" multicast="false"/></Interfaces></General><Discovery><ParticipantIndex>auto</ParticipantIndex>
<Peers><Peer address="127.0.0.1"/></Peers></Discovery></Domain></CycloneDDS>"#;

/// A domain that no other test has. Ports of domains from 101 on are among those that the system hands to others.
fn domain(test: u32) -> u16 {
    20 + ((8 * std::process::id() + test) % 80) as u16
}

/// A peer in Python, ended with the test.
struct Peer(Child);

impl Drop for Peer {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What a test needs: the file that shows that it is there, and its name.
type Needs = (&'static str, &'static str);
const CYCLONE: Needs = ("cyclonedds.ready", "CycloneDDS 0.10.2");
const SDK: Needs = ("sdk.ready", "the vendor's SDK on CycloneDDS 0.10.2");
const CPP: Needs = ("cpp.ready", "the vendor's C++ SDK");

/// Where `.ci/peers` has put them.
fn peers(test: &str, (ready, name): Needs) -> Option<PathBuf> {
    let program = std::env::current_exe().expect("this program");
    let folder = program.ancestors().nth(3).expect("target folder").join("peers");
    if folder.join(ready).exists() {
        return Some(folder);
    }
    paid_testing::skipped(test, &format!("{name}, which .ci/peers installs"));
    None
}

/// Begins a peer; its lines.
fn begin(folder: &Path, script: &str, arguments: &[&str]) -> (Peer, impl Iterator<Item = String> + use<>) {
    let scripts = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/peers");
    let mut child = Command::new(folder.join("venv/bin/python"))
        .arg(scripts.join(script))
        .args(arguments)
        .env("LD_LIBRARY_PATH", folder.join("cyclonedds/lib"))
        .env("CYCLONEDDS_URI", ON_LOOPBACK)
        .stdout(Stdio::piped())
        .spawn()
        .expect("a peer");
    let lines = BufReader::new(child.stdout.take().expect("its output")).lines();
    (Peer(child), lines.map_while(Result::ok))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

fn unhex(text: &str) -> Vec<u8> {
    let pairs = (0..text.len() / 2).map(|k| &text[2 * k..2 * k + 2]);
    pairs.map(|pair| u8::from_str_radix(pair, 16).expect("two digits")).collect()
}

/// Sends `say` until both sides have received; what the peer has sent, what it has received, what came from it.
fn exchange(test: &str, side: Side, domain: u16, say: &Packet) -> Option<([String; 2], String, Vec<u8>)> {
    let folder = peers(test, CYCLONE)?;
    let other = if side == Side::Robot { "runtime" } else { "robot" };
    let mut link = DdsLink::open(domain, LOOPBACK, side).expect("DDS");
    let (_peer, mut lines) = begin(&folder, "cyclone.py", &[other, &domain.to_string()]);
    let said = lines.next().expect("what it says");
    let (line, heard) = std::sync::mpsc::channel();
    std::thread::spawn(move || lines.next().map(|heard| line.send(heard)));
    let (mut got, mut told, begun) = (None, None, Instant::now());
    while got.is_none() || told.is_none() {
        assert!(
            begun.elapsed() < Duration::from_secs(90),
            "heard {}, was heard {}",
            got.is_some(),
            told.is_some()
        );
        link.send(say.clone()).expect("send");
        while let Some(packet) = link.receive().expect("receive") {
            if let Packet::LowCmd(bytes) | Packet::LowState(bytes) = packet {
                got.get_or_insert(bytes);
            }
        }
        if told.is_none() {
            told = heard.try_recv().ok();
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    let told: Vec<String> = told?.split(' ').map(str::to_owned).collect();
    Some(([told[1].clone(), told[2].clone()], said.trim_start_matches("says ").to_owned(), got?))
}

#[test]
fn cyclone_and_the_virtual_robot_exchange_state_and_command_byte_for_byte() {
    let mut state = LowState { mode_machine: 5, tick: 77, wireless_remote: [3; 40], ..LowState::default() };
    state.imu.rpy = [0.1, -0.2, 0.3];
    for (k, motor) in state.motors.iter_mut().enumerate() {
        motor.q = 0.01 * k as f32;
        motor.temperature = [k as i16, -3];
    }
    let state = state.sealed();
    let test = "cyclone_and_the_virtual_robot_exchange_state_and_command_byte_for_byte";
    let packet = Packet::LowState(state.to_cdr());
    let Some(([heard, crc], said, got)) = exchange(test, Side::Robot, domain(0), &packet) else { return };
    assert_eq!((heard, crc), (hex(&state.to_cdr()), state.crc.to_string()));
    assert_eq!(hex(&got), said);
    let command = LowCmd::from_cdr(&got).expect("a command");
    assert_eq!((command.mode_machine, command.crc, command.reserve), (5, 0xAABB_CCDD, [1, 2, 3, 4]));
    assert_eq!((command.motors[34].kp, command.motors[34].reserve), (74.0, 238));
}

#[test]
fn cyclone_and_the_runtime_exchange_command_and_state_byte_for_byte() {
    let mut command = LowCmd::damping(5, 29, 3.0);
    command.motors[7].q = -0.75;
    let command = command.sealed();
    let test = "cyclone_and_the_runtime_exchange_command_and_state_byte_for_byte";
    let packet = Packet::LowCmd(command.to_cdr());
    let Some(([heard, crc], said, got)) = exchange(test, Side::Runtime, domain(1), &packet) else { return };
    assert_eq!((heard, crc), (hex(&command.to_cdr()), command.crc.to_string()));
    assert_eq!(hex(&got), said);
    let state = LowState::from_cdr(&got).expect("a state");
    assert_eq!((state.tick, state.imu.temperature, state.crc), (4711, -12, 0x0102_0304));
    assert_eq!((state.motors[34].temperature, state.wireless_remote[39]), ([74, -34], 39));
}

#[test]
fn a_program_on_the_vendors_sdk_releases_and_moves_the_virtual_robot() {
    let test = "a_program_on_the_vendors_sdk_releases_and_moves_the_virtual_robot";
    let Some(folder) = peers(test, SDK) else { return };
    if !crate::common::mujoco(test) {
        return;
    }
    let player = player();
    let link = DdsLink::open(domain(2), LOOPBACK, Side::Robot).expect("DDS");
    let line = link.switcher().expect("DDS");
    let link = VendorLink::new(link, line, SwitcherService::new("ai"), &player);
    let stop = AtomicBool::new(false);
    let (served, lines) = std::thread::scope(|scope| {
        let robot = scope.spawn(|| serve(&player, link, ServeOptions::default(), &stop, &mut (), |_| None));
        let (_peer, lines) = begin(&folder, "sdk_commander.py", &[&domain(2).to_string(), "lo"]);
        let lines: Vec<String> = lines.collect();
        stop.store(true, Ordering::Relaxed);
        (robot.join().expect("robot"), lines)
    });
    let told = lines.join("; ");
    assert!(told.contains("master 'ai'; released; moved "), "{told}");
    let figures: Vec<&str> = lines.last().expect("a line").split(' ').collect();
    let moved: f64 = figures[1].parse().expect("a number");
    assert!((moved - 0.3).abs() < 0.06, "the elbow has moved by {moved} rad");
    assert_eq!(figures[5], "0", "wrong checksums: {told}");
    assert_eq!(served.expect("served").refused, 0, "commands of the vendor's SDK that the robot has refused");
}

#[test]
fn a_robot_on_the_vendors_sdk_hears_the_runtime_damp() {
    let test = "a_robot_on_the_vendors_sdk_hears_the_runtime_damp";
    let Some(folder) = peers(test, SDK) else { return };
    let (player, limits) = (player(), Limits::default());
    let link = DdsLink::open(domain(3), LOOPBACK, Side::Runtime).expect("DDS");
    let live = Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(Arc::clone(&player), limits),
        dry_run: false,
        log: None,
        switcher: None,
        keys: None,
        last_words: LastWords::default(),
        duration: Some(Duration::from_secs(90)),
    };
    let stop = AtomicBool::new(false);
    let (report, lines) = std::thread::scope(|scope| {
        let runtime = scope.spawn(|| run_live(live, link, &stop, |_| {}));
        let (_peer, lines) = begin(&folder, "sdk_robot.py", &[&domain(3).to_string(), "lo"]);
        let lines: Vec<String> = lines.collect();
        stop.store(true, Ordering::Relaxed);
        (runtime.join().expect("runtime"), lines)
    });
    assert_eq!(lines, ["heard True crc True damping True machine [5]"]);
    assert_eq!(report.expect("report").state, State::Damping, "it damps in the end");
}

#[test]
fn a_battery_on_the_vendors_sdk_is_heard_by_the_runtime_byte_for_byte() {
    let test = "a_battery_on_the_vendors_sdk_is_heard_by_the_runtime_byte_for_byte";
    let Some(folder) = peers(test, SDK) else { return };
    let mut runtime = DdsLink::open(domain(4), LOOPBACK, Side::Runtime).expect("DDS");
    let (_peer, mut lines) = begin(&folder, "sdk_battery.py", &["says", &domain(4).to_string(), "lo"]);
    let said = lines.next().expect("what it says");
    let said = said.trim_start_matches("says ");
    let battery = BmsState::from_cdr(&unhex(said)).expect("a battery");
    assert_eq!((battery.percent(), battery.soh, battery.current, battery.cycle), (Some(63.0), 97, -1500, 77));
    assert_eq!((battery.cell_vol[39], battery.temperature[11], battery.reserve), (4039, 11, [9; 3]));
    assert_eq!(hex(&battery.to_cdr()), said);
    let begun = Instant::now();
    loop {
        assert!(begun.elapsed() < Duration::from_secs(90), "nothing was heard");
        if let Some(packet) = runtime.receive().expect("receive") {
            assert_eq!(packet, Packet::Battery(63.0));
            break;
        }
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn the_virtual_robots_battery_is_heard_by_the_vendors_sdk() {
    let test = "the_virtual_robots_battery_is_heard_by_the_vendors_sdk";
    let Some(folder) = peers(test, SDK) else { return };
    let mut robot = DdsLink::open(domain(5), LOOPBACK, Side::Robot).expect("DDS");
    let (_peer, mut lines) = begin(&folder, "sdk_battery.py", &["hears", &domain(5).to_string(), "lo"]);
    let (line, told) = std::sync::mpsc::channel();
    std::thread::spawn(move || lines.next().map(|heard| line.send(heard)));
    let begun = Instant::now();
    let heard = loop {
        assert!(begun.elapsed() < Duration::from_secs(90), "it has heard nothing");
        robot.send(Packet::Battery(42.0)).expect("send");
        if let Ok(heard) = told.recv_timeout(Duration::from_millis(20)) {
            break heard;
        }
    };
    assert_eq!(heard, "heard (42, 100, 0, 0)");
}

#[test]
fn a_program_on_the_vendors_cpp_sdk_moves_the_virtual_robot() {
    let test = "a_program_on_the_vendors_cpp_sdk_moves_the_virtual_robot";
    let Some(folder) = peers(test, CPP) else { return };
    if !crate::common::mujoco(test) {
        return;
    }
    let player = player();
    let link = DdsLink::open(domain(6), LOOPBACK, Side::Robot).expect("DDS");
    let stop = AtomicBool::new(false);
    let (served, lines) = std::thread::scope(|scope| {
        let robot = scope.spawn(|| serve(&player, link, ServeOptions::default(), &stop, &mut (), |_| None));
        let (_peer, lines) = begin(&folder, "cpp_commander.py", &[&domain(6).to_string()]);
        let lines: Vec<String> = lines.collect();
        stop.store(true, Ordering::Relaxed);
        (robot.join().expect("robot"), lines)
    });
    let told = lines.join("; ");
    assert!(told.contains("machine 5 upright True casing 45; "), "{told}");
    let moved = lines.iter().find_map(|line| line.strip_prefix("moved ")).expect("moved");
    let moved: f64 = moved.parse().expect("a number");
    assert!((moved - 0.3).abs() < 0.06, "the elbow has moved by {moved} rad");
    assert_eq!(served.expect("served").refused, 0, "commands of the vendor's SDK that the robot has refused");
}

#[test]
fn a_robot_on_the_vendors_cpp_sdk_says_that_it_is_released_and_hears_the_runtime_damp() {
    let test = "a_robot_on_the_vendors_cpp_sdk_says_that_it_is_released_and_hears_the_runtime_damp";
    let Some(folder) = peers(test, CPP) else { return };
    let (player, limits) = (player(), Limits::default());
    let link = DdsLink::open(domain(7), LOOPBACK, Side::Runtime).expect("DDS");
    let (_peer, mut lines) = begin(&folder, "cpp_robot.py", &[&domain(7).to_string()]);
    let mut client = SwitcherClient::new(link.switcher().expect("DDS"));
    let patience = Patience { answer: Duration::from_secs(60), ..Patience::default() };
    await_release(&mut client, false, patience, &AtomicBool::new(false), |_| {}).expect("released");
    let live = Live {
        writer: Writer::new(&limits, player.joints()),
        runtime: Runtime::new(Arc::clone(&player), limits),
        dry_run: false,
        log: None,
        switcher: Some(client.into_line()),
        keys: None,
        last_words: LastWords::default(),
        duration: Some(Duration::from_secs(90)),
    };
    let stop = AtomicBool::new(false);
    let (report, heard) = std::thread::scope(|scope| {
        let runtime = scope.spawn(|| run_live(live, link, &stop, |_| {}));
        let heard = lines.find(|line| line.starts_with("heard"));
        stop.store(true, Ordering::Relaxed);
        (runtime.join().expect("runtime"), heard)
    });
    assert_eq!(heard.as_deref(), Some("heard True kp [0.0] kd [3.0]"));
    let report = report.expect("report");
    assert_eq!(report.state, State::Damping, "it damps in the end");
}
