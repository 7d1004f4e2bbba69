//! `paid robot` as a program: a dry run, real signals, a closed pipe, lines of JSON, and exit codes. The virtual robot runs in the test, over DDS on the loopback.

use std::io::{BufRead, BufReader};
use std::net::{IpAddr, Ipv4Addr};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use crate::common::{paid, refuses, succeeds, text};
use paid_runtime::wire::{Key, LowCmd};
use paid_runtime::{DdsLink, Player, PlayerSpec, Side};
use paid_twin::{Order, ServeOptions, VirtualG1, serve};
use serde_json::Value;

/// Programs on a loopback without multicast connect after some seconds; a busy machine takes longer.
const PATIENCE: Duration = Duration::from_secs(120);

fn policy() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../policies/demo/policy.onnx")
}

/// A domain whose ports the system does not hand to others.
fn domain(test: u32) -> u16 {
    20 + ((5 * std::process::id() + test) % 80) as u16
}

/// A program that ends with the test.
struct Ended(Child);

impl Drop for Ended {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// `paid robot run --json` on this domain, and its lines.
fn begin(folder: &Path, domain: u16, more: &[&str]) -> (Ended, Receiver<String>) {
    // The machine may be busy: nothing but the test may end it.
    let limits =
        "state_gap_s = 0.1\ncommand_age_s = 0.1\nwriter_age_s = 0.5\nlate_s = 0.1\nlate_steps = 10\n";
    std::fs::write(folder.join("limits.toml"), limits).expect("write");
    let mut program = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(["robot", "run", "--domain", &domain.to_string(), "--interface", "127.0.0.1", "--json"])
        .args(["--no-switcher", "--virtual-senses", "--limits", "limits.toml", "--policy"])
        .arg(policy())
        .args(more)
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let lines = BufReader::new(program.stdout.take().expect("output")).lines().map_while(Result::ok);
    let (to, from) = channel();
    // Ends, and closes the program's output, when no more lines are needed.
    std::thread::spawn(move || lines.map_while(|line| to.send(line).ok()).for_each(drop));
    (Ended(program), from)
}

/// How the program is ended.
#[derive(Clone, Copy)]
enum Ends {
    /// By these signals, one right after the other.
    Signals(&'static [&'static str]),
    /// The reader of its output goes away.
    Reader,
}

/// What the program did to a robot that was asked to stand up, and was then stopped.
struct Course {
    /// Commands that hold the joints, and damping after the signal, seen by the robot [2 ms each].
    held: usize,
    damped: usize,
    status: ExitStatus,
    lines: Vec<Value>,
}

/// A robot for the program: L2 and Up again and again until a line of it says `stand up`, a signal when `enough` says so.
fn play(
    folder: &Path,
    domain: u16,
    more: &[&str],
    ends: Ends,
    enough: impl Fn(usize, Duration) -> bool,
) -> Course {
    let player = Player::load(&PlayerSpec { policy: policy(), motions: None, sets: Vec::new() });
    let player = Arc::new(player.expect("policy"));
    let link = DdsLink::open(domain, IpAddr::V4(Ipv4Addr::LOCALHOST), Side::Robot).expect("DDS");
    let (mut program, from) = begin(folder, domain, more);
    let mut from = Some(from);
    let (begin, stop) = (Instant::now(), AtomicBool::new(false));
    let (mut held, mut damped, mut next_s, mut up, mut signal) = (0, 0, 1.0, None, None);
    let (mut lines, mut status) = (Vec::new(), None);
    let orders = |robot: &VirtualG1| {
        let command: &LowCmd = robot.command();
        let holds = command.motors[..29].iter().any(|motor| motor.kp > 0.0);
        let damps = command.motors[..29].iter().all(|m| m.mode == 1 && m.kp == 0.0 && m.kd > 0.0);
        held += usize::from(holds);
        damped += usize::from(signal.is_some() && damps && !robot.timed_out());
        for line in from.iter().flat_map(Receiver::try_iter) {
            let line: Value = serde_json::from_str(&line).unwrap_or_else(|e| panic!("{line}: {e}"));
            if line["event"]["to"] == "stand_up" {
                up.get_or_insert_with(Instant::now);
            }
            lines.push(line);
        }
        if signal.is_none() && up.is_some_and(|at| enough(held, at.elapsed())) {
            match ends {
                Ends::Signals(names) => {
                    names.iter().for_each(|name| crate::common::kill(name, program.0.id()));
                }
                Ends::Reader => from = None,
            }
            signal = Some(Instant::now());
        }
        if signal.is_some() && status.is_none() {
            status = program.0.try_wait().expect("a program");
        }
        if status.is_some() || begin.elapsed() > PATIENCE {
            stop.store(true, Ordering::Relaxed);
        }
        let now_s = robot.now_us() as f64 * 1e-6;
        (now_s >= next_s && up.is_none()).then(|| {
            next_s = now_s + 1.0;
            Order::Keys(vec![Key::L2, Key::Up])
        })
    };
    serve(&player, link, ServeOptions::default(), &stop, &mut (), orders).expect("served");
    lines.extend(from.iter().flatten().map(|line| serde_json::from_str::<Value>(&line).expect("JSON")));
    Course { held, damped, status: status.expect("ended by the signal"), lines }
}

/// The line that ends a run.
fn end(course: &Course) -> &Value {
    let last = course.lines.last().expect("lines");
    assert!(last["end"].is_object(), "{last}");
    &last["end"]
}

#[test]
fn a_signal_damps_a_robot_that_stands_up_and_the_program_says_how_it_went() {
    if !crate::common::mujoco("a_signal_damps_a_robot_that_stands_up_and_the_program_says_how_it_went") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let course = play(folder.path(), domain(0), &[], Ends::Signals(&["-INT"]), |held, _| held > 100);
    assert!(course.status.success(), "{}", course.status);
    // Half a second of damping is said; the robot has seen most of it.
    assert!(course.held > 100 && course.damped > 100, "{} held, {} damped", course.held, course.damped);
    let reasons: Vec<&str> =
        course.lines.iter().filter_map(|line| line["event"]["reason"].as_str()).collect();
    assert!(reasons.contains(&"stop signal"), "{reasons:?}");
    assert!(course.lines.iter().any(|line| line["status"]["state"].is_string()));
    let end = end(&course);
    assert!(end["died"].is_null() && end["commands_late"]["periods"].as_u64() > Some(100), "{end}");
    assert!(end["bare_timer_late"]["periods"].as_u64() > Some(100), "the timer runs too: {end}");
    assert!(end["usage"]["cpu_s"].as_f64() > Some(0.0) && end["usage"]["peak_rss_mib"].as_f64() > Some(1.0));
}

#[test]
fn a_terminal_that_is_closed_damps_the_robot() {
    if !crate::common::mujoco("a_terminal_that_is_closed_damps_the_robot") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    // Ctrl-Z does not halt the commands; a shell that ends hangs up, and its terminal does so too.
    let signals = Ends::Signals(&["-TSTP", "-HUP", "-HUP"]);
    let course = play(folder.path(), domain(3), &[], signals, |held, _| held > 100);
    assert!(course.status.success(), "{}", course.status);
    assert!(course.held > 100 && course.damped > 100, "{} held, {} damped", course.held, course.damped);
    assert!(end(&course)["died"].is_null());
}

#[test]
fn a_reader_that_goes_away_damps_the_robot() {
    if !crate::common::mujoco("a_reader_that_goes_away_damps_the_robot") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let course = play(folder.path(), domain(4), &[], Ends::Reader, |held, _| held > 100);
    assert!(!course.status.success(), "{}", course.status);
    assert!(course.held > 100 && course.damped > 100, "{} held, {} damped", course.held, course.damped);
}

#[test]
fn a_dry_run_thinks_and_logs_and_commands_nothing() {
    if !crate::common::mujoco("a_dry_run_thinks_and_logs_and_commands_nothing") {
        return;
    }
    let folder = tempfile::tempdir().expect("a folder");
    let more = ["--dry-run", "--log", "dry.mcap"];
    let course = play(folder.path(), domain(1), &more, Ends::Signals(&["-INT"]), |_, up| {
        up > Duration::from_millis(500)
    });
    assert!(course.status.success(), "{}", course.status);
    assert_eq!((course.held, course.damped), (0, 0), "commands of a dry run");
    assert!(course.lines.iter().any(|line| line["status"]["dry_run"] == true));
    assert!(end(&course)["steps"].as_u64() > Some(100));
    // Its log replays bit for bit: exit code 0.
    let said = succeeds(&paid(folder.path(), &["robot", "replay", "dry.mcap"]));
    assert!(said.ends_with("all commands, observations and actions are equal bit for bit\n"), "{said}");
}

#[test]
fn exit_codes_tell_what_was_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let silent = domain(2).to_string();
    let check = [
        "robot",
        "check",
        "--domain",
        &silent,
        "--interface",
        "127.0.0.1",
        "--seconds",
        "0.5",
        "--no-switcher",
    ];
    let output = paid(here, &check);
    assert_eq!(output.status.code(), Some(1));
    let said = text(&output);
    assert!(said.contains("no state came") && said.ends_with("NOT good: do not start\n"), "{said}");
    if crate::common::mujoco("exit_codes_tell_what_was_found") {
        let policy = policy();
        let policy = policy.to_str().expect("a path");
        let drill = ["robot", "drill", "--trials", "1", "--fault", "StopKey", "--policy", policy];
        assert!(succeeds(&paid(here, &drill)).contains("1 of 1 passed"));
    }
    let absent = ["robot", "replay", "absent.mcap"];
    assert!(refuses(&paid(here, &absent)).contains("absent.mcap"));
    std::fs::write(here.join("other.mcap"), "no log").expect("write");
    let other = ["robot", "replay", "other.mcap"];
    assert!(refuses(&paid(here, &other)).contains("other.mcap"));
}

/// `paid robot run` with the motion switcher, which no program plays on this domain: the request would be repeated for 20 s.
fn run_args<'a>(domain: &'a str, policy: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    let run = ["robot", "run", "--domain", domain, "--interface", "127.0.0.1", "--policy", policy];
    [&run[..], more].concat()
}

#[test]
fn bad_input_is_refused_before_anybody_is_asked_to_release_the_robot() {
    let folder = tempfile::tempdir().expect("a folder");
    let here = folder.path();
    let (domain, policy) = (domain(2).to_string(), policy());
    let (stage1, policy) = (
        policy.with_file_name("../../crates/skill/train/tests/samples/stage1.safetensors"),
        policy.to_str().expect("a path"),
    );
    std::fs::write(here.join("eyes.toml"), "colour = 1\n").expect("write");
    std::fs::write(
        here.join("nobodys.toml"),
        "interface = \"192.0.2.1\"\n[odometry]\nsource = \"topic\"\ntopic = \"/odometry\"\n",
    )
    .expect("write");
    std::fs::write(here.join("old.mcap"), "the only log").expect("write");
    let cases: [(&[&str], &str); 9] = [
        (&["--seconds=-1"], "--seconds: expected 0 to 1000000, found -1.0"),
        (&["--seconds", "-1"], "--seconds: expected 0 to 1000000, found -1.0"),
        (&["--seconds", "nan"], "--seconds: expected 0 to 1000000, found NaN"),
        (&["--seconds", "1e300"], "--seconds: expected 0 to 1000000, found 1e300"),
        (&["--eyes", "absent.toml"], "absent.toml: "),
        (&["--eyes", "eyes.toml"], "colour"),
        (&["--eyes", "nobodys.toml"], "expected an address of this machine"),
        (&["--log", "absent/new.mcap"], "absent/new.mcap: "),
        (&["--log", "old.mcap"], "old.mcap: expected a new file"),
    ];
    for (more, expected) in cases {
        let release = [&["--release"], more].concat();
        let begin = Instant::now();
        let error = refuses(&paid(here, &run_args(&domain, policy, &release)));
        assert!(error.contains(expected), "{more:?}: {error}");
        assert!(!error.contains("no answer on"), "{more:?}: {error} after {:?}", begin.elapsed());
    }
    assert_eq!(std::fs::read(here.join("old.mcap")).expect("read"), b"the only log");
    let stage1 = run_args(&domain, stage1.to_str().expect("a path"), &["--dry-run"]);
    let error = refuses(&paid(here, &stage1));
    assert!(error.contains("expected a policy of a task with a ball"), "{error}");
    for seconds in ["nan", "-5"] {
        let check = ["robot", "check", "--domain", &domain, "--interface", "127.0.0.1", "--seconds", seconds];
        let error = refuses(&paid(here, &check));
        assert!(error.contains("--seconds: expected 0 to 1000000, found "), "{error}");
    }
    let check = ["robot", "check", "--domain", &domain, "--interface", "127.0.0.1", "--seconds", "0.2"];
    let output = paid(here, &[&check[..], &["--no-switcher"]].concat());
    let said = String::from_utf8_lossy(&output.stdout);
    let expected = "no state of the robot: found no publisher of rt/lowstate\nNOT good";
    assert!(output.status.code() == Some(1) && said.contains(expected), "{said}");
    // An interface of another machine: no log stays behind.
    let elsewhere = ["robot", "run", "--domain", &domain, "--interface", "192.0.2.1", "--policy", policy];
    let error = refuses(&paid(here, &[&elsewhere[..], &["--log", "new.mcap"]].concat()));
    assert!(
        error.contains("expected an address of this machine (") && error.contains("127.0.0.1"),
        "{error}"
    );
    assert!(!here.join("new.mcap").exists());
}

#[test]
fn a_signal_while_the_motion_switcher_is_waited_for_says_stopped() {
    let folder = tempfile::tempdir().expect("a folder");
    let (domain, policy, log) = (domain(2).to_string(), policy(), folder.path().join("new.mcap"));
    let run = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(run_args(&domain, policy.to_str().expect("a path"), &["--log", "new.mcap"]))
        .current_dir(folder.path())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let begin = Instant::now();
    // The log is begun right before the network is joined.
    while !log.exists() {
        assert!(begin.elapsed() < PATIENCE, "no log");
        std::thread::sleep(Duration::from_millis(5));
    }
    crate::common::kill("-INT", run.id());
    let output = run.wait_with_output().expect("it ends");
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(130), "{error}");
    assert!(error.contains("stopped before the start") && !error.contains("no answer on"), "{error}");
    assert!(!log.exists(), "a log without a step");
}
