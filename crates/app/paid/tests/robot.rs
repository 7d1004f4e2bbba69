//! `paid robot` as a program of its own: killed while it holds a virtual robot, and refusing what it must.

use std::cell::Cell;
use std::io::{BufRead, BufReader, Write};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crate::common::{paid, refuses, succeeds};
use paid_runtime::log::LogReader;
use paid_runtime::wire::{Key, LowState};
use paid_runtime::{DdsLink, Packet, Player, PlayerSpec, Side};
use paid_twin::{Order, ServeOptions, VirtualG1, Watcher, serve};
use paid_world::{Message, Recorded, Recording};
use serde_json::Value;

/// Programs on a loopback without multicast connect after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(120);

fn policy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx")
}

/// A domain whose ports the system does not hand to others.
fn domain(test: u32) -> u16 {
    20 + ((3 * std::process::id() + test) % 80) as u16
}

/// A program that ends with the test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// What the killer knows and reports.
#[derive(Default)]
struct Told {
    /// The robot's joints are held by a command.
    held: Cell<bool>,
    killed: Cell<Option<Instant>>,
    /// The robot's clock at the kill `[us]`.
    killed_us: Cell<u64>,
    /// From the kill to the robot's own stop.
    stopped: Cell<Option<Duration>>,
    /// Highest joint speed half a second after it `[rad/s]`.
    speed: Cell<Option<f64>>,
}

/// Kills the runtime once it holds the robot, and waits for the robot's own timeout.
struct Killer<'a> {
    runtime: Ended,
    told: Rc<Told>,
    held_us: u64,
    stop: &'a AtomicBool,
    begin: Instant,
    stopped_us: u64,
}

impl Watcher for Killer<'_> {
    fn step(&mut self, robot: &VirtualG1) {
        let told = &self.told;
        if let Some(killed) = told.killed.get() {
            if told.stopped.get().is_none() && robot.timed_out() {
                told.stopped.set(Some(killed.elapsed()));
                self.stopped_us = robot.now_us();
            }
            if told.stopped.get().is_some() && robot.now_us() >= self.stopped_us + 500_000 {
                let speeds = &robot.truth().joint_vel;
                told.speed.set(Some(speeds.iter().fold(0.0, |most: f64, v| most.max(v.abs()))));
                self.stop.store(true, Ordering::Relaxed);
            }
        } else if robot.command().motors[3].kp > 0.0 {
            told.held.set(true);
            self.held_us += 2_000;
            if self.held_us >= 200_000 {
                // SIGKILL on Unix: the program can send nothing more.
                self.runtime.0.kill().expect("kill");
                self.runtime.0.wait().expect("it is dead");
                told.killed.set(Some(Instant::now()));
                told.killed_us.set(robot.now_us());
            }
        }
        if self.begin.elapsed() > PATIENCE {
            self.stop.store(true, Ordering::Relaxed);
        }
    }
    fn goal(&mut self, _center: [f64; 2], _heading: f64) {}
}

#[test]
fn a_robot_whose_runtime_is_killed_stops_by_its_own_timeout() {
    if !crate::common::mujoco("a_robot_whose_runtime_is_killed_stops_by_its_own_timeout") {
        return;
    }
    let player = Player::load(&PlayerSpec { policy: policy(), motions: None, sets: Vec::new() });
    let player = Arc::new(player.expect("policy"));
    let folder = tempfile::tempdir().expect("a folder");
    // The machine may be busy: nothing but the kill may end it.
    let limits =
        "state_gap_s = 0.1\ncommand_age_s = 0.1\nwriter_age_s = 0.5\nlate_s = 0.1\nlate_steps = 10\n";
    std::fs::write(folder.path().join("limits.toml"), limits).expect("write");
    let link = DdsLink::open(domain(0), IpAddr::V4(Ipv4Addr::LOCALHOST), Side::Robot).expect("DDS");
    let runtime = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(["robot", "run", "--domain", &domain(0).to_string(), "--interface", "127.0.0.1"])
        .args([
            "--no-switcher",
            "--virtual-senses",
            "--quiet",
            "--limits",
            "limits.toml",
            "--log",
            "killed.mcap",
        ])
        .arg("--policy")
        .arg(policy())
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    let (stop, told) = (AtomicBool::new(false), Rc::new(Told::default()));
    let (begin, told_too) = (Instant::now(), Rc::clone(&told));
    let mut killer = Killer {
        runtime: Ended(runtime),
        told: Rc::clone(&told),
        held_us: 0,
        stop: &stop,
        begin,
        stopped_us: 0,
    };
    // Pressed every second until it stands up.
    let mut next_s = 1.0;
    let orders = |robot: &VirtualG1| {
        let now_s = robot.now_us() as f64 * 1e-6;
        (now_s >= next_s && !told_too.held.get()).then(|| {
            next_s = now_s + 1.0;
            Order::Keys(vec![Key::L2, Key::Up])
        })
    };
    serve(&player, link, ServeOptions::default(), &stop, &mut killer, orders).expect("served");
    assert!(told.held.get(), "the runtime has never held the robot");
    let stopped = told.stopped.get().expect("the robot's own stop");
    let speed = told.speed.get().expect("half a second more");
    println!(
        "stopped {:.0} ms after the kill; joints at {speed:.2} rad/s half a second later",
        stopped.as_secs_f64() * 1e3
    );
    assert!(speed < 1.0, "{speed} rad/s");
    // Its log lacks no more than the end, and what there is replays bit for bit.
    let mut log = LogReader::open(&folder.path().join("killed.mcap")).expect("a log");
    let mut last_tick = 0;
    while let Some(frame) = log.next_frame().expect("a frame") {
        for packet in &frame.packets {
            if let Packet::LowState(bytes) = packet {
                last_tick = LowState::from_cdr(bytes).expect("a state").tick;
            }
        }
    }
    let lost_ms = told.killed_us.get() / 1000 - u64::from(last_tick);
    println!("the log ends {lost_ms} ms before the kill");
    // A twentieth of a second on a machine that is not busy.
    assert!(lost_ms < 1000, "{lost_ms} ms");
    let said = succeeds(&paid(folder.path(), &["robot", "replay", "killed.mcap"]));
    assert!(said.ends_with("all commands, observations and actions are equal bit for bit\n"), "{said}");
}

#[test]
fn a_virtual_robot_begins_standing_and_refuses_faults_that_it_cannot_have() {
    if !crate::common::mujoco("a_virtual_robot_begins_standing_and_refuses_faults_that_it_cannot_have") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let domain = domain(1).to_string();
    let mut robot = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args([
            "robot",
            "sim",
            "--standing",
            "--camera-hz",
            "0",
            "--domain",
            &domain,
            "--interface",
            "127.0.0.1",
        ])
        .arg("--policy")
        .arg(policy())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut lines = BufReader::new(robot.stdout.take().expect("output")).lines().map_while(Result::ok);
    let first = lines.next().expect("a line");
    assert!(first.ends_with("held by a support until its joints hold it"), "{first}");
    let mut orders = robot.stdin.take().expect("input");
    writeln!(orders, "fault kill\nquit").expect("orders");
    let mut said = BufReader::new(robot.stderr.take().expect("errors")).lines().map_while(Result::ok);
    let refusal = said.find(|line| line.starts_with("fault kill")).expect("a refusal");
    assert!(refusal.contains("`paid robot drill --fault kill` has it"), "{refusal}");
    assert!(robot.wait().expect("it ends").success());
    // A script is refused before anything begins.
    std::fs::write(folder.path().join("script"), "1 keys L2+Up\n2 fault hang\n").expect("write");
    let policy = policy();
    let sim =
        ["robot", "sim", "--domain", &domain, "--interface", "127.0.0.1", "--script", "script", "--policy"];
    let output = paid(folder.path(), &[&sim[..], &[policy.to_str().expect("a path")]].concat());
    let error = refuses(&output);
    assert!(error.contains("script, line 2: fault hang: expected a fault of the robot"), "{error}");
}

#[test]
fn a_virtual_robot_on_the_network_records_its_pictures_though_nobody_reads_them() {
    if !crate::common::mujoco("a_virtual_robot_on_the_network_records_its_pictures_though_nobody_reads_them")
    {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    std::fs::write(folder.path().join("script"), "1 ball 1 0\n2 quit\n").expect("write");
    let (domain, policy) = (domain(2).to_string(), policy());
    let policy = policy.to_str().expect("a path");
    let place = ["--domain", &domain, "--interface", "127.0.0.1", "--policy", policy];
    let sim = |more: &[&str]| paid(folder.path(), &[&["robot", "sim"], more, &place[..]].concat());
    succeeds(&sim(&["--script", "script", "--record", "seen.mcap"]));
    let mut pictures = 0;
    let recording = Recording::open(&folder.path().join("seen.mcap")).expect("a file");
    let count = |recorded| {
        if let Recorded::Message(arrived) = recorded
            && let Message::Picture(picture) = arrived.message
        {
            assert!(picture.depth.is_some(), "its depth");
            pictures += 1;
        }
        Ok(())
    };
    recording.read(count).expect("a whole recording");
    // 15 a second; a busy machine drops some.
    assert!((2..=31).contains(&pictures), "{pictures}");
    let error = refuses(&sim(&["--record", "seen.mcap", "--camera-hz", "0"]));
    assert!(error.contains("--record: expected images, found --camera-hz 0"), "{error}");
    let blind = ["robot", "sim", "--lockstep", "--record", "seen.mcap", "--policy", policy];
    let error = refuses(&paid(folder.path(), &blind));
    assert!(
        error.contains("--record: expected --eyes in lockstep, which renders the images, found none"),
        "{error}"
    );
}

#[test]
fn matches_in_lockstep_have_a_log_each_and_write_over_none() {
    if !crate::common::mujoco("matches_in_lockstep_have_a_log_each_and_write_over_none") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let policy = policy();
    let policy = policy.to_str().expect("a path");
    let sim =
        |more: &[&str]| paid(here, &[&["robot", "sim", "--lockstep", "--policy", policy][..], more].concat());
    let two = ["--kicks", "1", "--matches", "2", "--seed", "3", "--log", "match.mcap"];
    let said = succeeds(&sim(&two));
    assert!(said.contains("2 matches: "), "{said}");
    assert!(!here.join("match.mcap").exists());
    for log in ["match_3.mcap", "match_4.mcap"] {
        let mut reader = LogReader::open(&here.join(log)).expect("a log");
        assert!(reader.next_frame().expect("a frame").is_some(), "{log}");
    }
    let lag = succeeds(&paid(here, &["robot", "lag", "match_3.mcap", "match_4.mcap", "--json"]));
    let lag: Value = serde_json::from_str(&lag).expect("JSON");
    let knee = lag["rows"].as_array().expect("rows").iter().find(|row| row["joint"] == "knee");
    let knee_ms = knee.and_then(|row| row["lag_ms"].as_f64()).expect("a lag");
    assert!((20.0..=120.0).contains(&knee_ms), "{knee_ms} ms");
    // Of a log that was cut off early, the robot has not got up yet.
    let whole = std::fs::read(here.join("match_3.mcap")).expect("read");
    std::fs::write(here.join("early.mcap"), &whole[..300_000]).expect("write");
    let error = refuses(&paid(here, &["robot", "lag", "early.mcap"]));
    assert!(
        error.contains("early.mcap: expected steps of a policy with joint targets, found none"),
        "{error}"
    );
    // The first match has a new name, the second would write over an old log: nothing is played.
    std::fs::remove_file(here.join("match_3.mcap")).expect("remove");
    let before = std::fs::read(here.join("match_4.mcap")).expect("read");
    let error = refuses(&sim(&two));
    assert!(error.contains("match_4.mcap: expected a new file"), "{error}");
    assert!(!here.join("match_3.mcap").exists());
    assert_eq!(std::fs::read(here.join("match_4.mcap")).expect("read"), before);
}

#[test]
fn nothing_to_play_and_nothing_to_drill_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let (domain, policy) = (domain(1).to_string(), policy());
    let policy = policy.to_str().expect("a path");
    let network = ["sim", "--domain", &domain, "--interface", "127.0.0.1"];
    let elsewhere = ["sim", "--domain", &domain, "--interface", "192.0.2.1"];
    let last = u64::MAX.to_string();
    let cases: [(&[&str], &[&str], &str); 6] = [
        (&["sim", "--lockstep"], &["--matches", "0"], "--matches: expected at least 1, found 0"),
        (&["sim", "--lockstep"], &["--kicks", "0"], "--kicks: expected at least 1, found 0"),
        (&network, &["--kicks", "0"], "--kicks: expected at least 1, found 0"),
        (&["drill"], &["--trials", "0"], "--trials: expected at least 1, found 0"),
        (&["sim", "--lockstep"], &["--matches", "2", "--seed", &last], "--seed: expected a last seed up to"),
        (&elsewhere, &[], "expected an address of this machine ("),
    ];
    for (command, more, expected) in cases {
        let args = [&["robot"][..], command, &["--policy", policy], more].concat();
        let error = refuses(&paid(folder.path(), &args));
        assert!(error.contains(expected), "{args:?}: {error}");
    }
}
