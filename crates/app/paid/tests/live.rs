//! `--live` of a training and of a virtual robot: the page is there, and a watched training is the same.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Command, Stdio};
use std::thread;

use crate::common::{paid, succeeds, text};
use paid_live::{Command as Wish, Frame};
use paid_mujoco::Library;
use tungstenite::Message;

/// Three iterations, with a checkpoint after each.
const RUN: [&str; 18] = [
    "train",
    "stage1",
    "--json",
    "--threads",
    "1",
    "--iterations",
    "3",
    "--set",
    "run.envs=64",
    "--set",
    "run.shards=2",
    "--set",
    "run.checkpoint_interval=1",
    "--set",
    "learn.precision=f32",
    "--set",
    "phases=[]",
    "--out",
];

#[test]
fn a_training_that_is_watched_is_the_same() {
    let folder = tempfile::tempdir().expect("a folder");
    let mut child = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(RUN)
        .args(["watched", "--live", "--port", "0"])
        .current_dir(folder.path())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    let mut errors = BufReader::new(child.stderr.take().expect("piped"));
    errors.read_line(&mut line).expect("text");
    let address = line.split(['/', ' ']).nth(2).expect("http://IP:PORT/").to_owned();
    let ask = |request: &str| {
        let mut stream = TcpStream::connect(&address).expect("the page is served");
        write!(stream, "GET {request}\r\nHost: {address}\r\n").expect("sent");
        stream
    };
    // A page that watches until the end.
    let mut viewer = ask("/ws HTTP/1.1");
    let upgrade = "Upgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n";
    viewer.write_all(upgrade.as_bytes()).expect("sent");
    let watching = thread::spawn(move || {
        let mut seen = Vec::new();
        // The end of the program may come as an error.
        let _ = viewer.read_to_end(&mut seen);
        String::from_utf8_lossy(&seen).into_owned()
    });
    let mut page = String::new();
    let mut stream = ask("/ HTTP/1.1\r\nConnection: close");
    stream.write_all(b"\r\n").expect("sent");
    stream.read_to_string(&mut page).expect("the page");
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("id=\"curves\""), "{page:.200}");
    // Visitors that ask twice and do not wait: to answer them ends nothing.
    for _ in 0..20 {
        // The program may have ended by now.
        let Ok(mut gone) = TcpStream::connect(&address) else { break };
        let get = |file: &str| format!("GET /{file} HTTP/1.1\r\nHost: {address}\r\n\r\n");
        let _ = gone.write_all((get("") + &get("main.js")).as_bytes());
    }
    let watched = child.wait_with_output().expect("it ends");
    let records = succeeds(&watched);
    assert_eq!(records.lines().count(), 3, "nothing but records: {records}");
    assert!(watching.join().expect("no panic").starts_with("HTTP/1.1 101"));

    let plain = paid(folder.path(), &[&RUN[..], &["plain"]].concat());
    succeeds(&plain);
    let read = |run: &str, file: &str| fs::read(folder.path().join(run).join(file)).expect(file);
    for file in ["policy.onnx", "preset.toml"] {
        assert!(read("watched", file) == read("plain", file), "{file}");
    }
    assert_eq!(text(&plain).lines().count(), 3);
}

#[test]
fn a_page_that_cannot_be_served_is_said_and_does_not_stop_the_training() {
    let folder = tempfile::tempdir().expect("a folder");
    let taken = std::net::TcpListener::bind("127.0.0.1:0").expect("a port");
    let port = taken.local_addr().expect("an address").port().to_string();
    let mut run = RUN.to_vec();
    run[6] = "1";
    let output = paid(folder.path(), &[&run[..], &["run", "--live", "--port", &port]].concat());
    assert_eq!(succeeds(&output).lines().count(), 1);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(
        errors.matches("--live: the page cannot be served, training continues").count(),
        1,
        "{errors}"
    );
}

#[test]
fn a_match_of_the_virtual_robot_can_be_watched_and_stopped() {
    let test = "a_match_of_the_virtual_robot_can_be_watched_and_stopped";
    let Some(_) = paid_testing::mujoco(test, Library::get()) else { return };
    let policy = concat!(env!("CARGO_MANIFEST_DIR"), "/../../../policies/demo/policy.onnx");
    let mut child = Command::new(env!("CARGO_BIN_EXE_paid"))
        .args(["robot", "sim", "--lockstep", "--live", "--port", "0", "--policy", policy])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut output = BufReader::new(child.stdout.take().expect("piped"));
    let mut line = String::new();
    output.read_line(&mut line).expect("text");
    let address = line.split(['/', ' ']).nth(2).expect("http://IP:PORT/").to_owned();
    let stream = TcpStream::connect(&address).expect("the page is served");
    let (mut page, _) = tungstenite::client(format!("ws://{address}/ws"), stream).expect("a page");
    // Time passes while the page is open. In the first kick it stops the robot.
    let (mut seen, mut asked) = (0, false);
    while let Ok(message) = page.read() {
        let Message::Binary(bytes) = message else { continue };
        let frame = Frame::decode(&bytes).expect("a frame");
        seen += 1;
        if frame.flags.kicking && !asked {
            assert!(frame.belief.is_some() && frame.bodies.len() > 29);
            page.send(Message::Binary(Wish::Stop.encode().into())).expect("sent");
            asked = true;
        }
    }
    let mut rest = String::new();
    output.read_to_string(&mut rest).expect("text");
    assert!(child.wait().expect("it ends").success());
    assert!(asked && seen > 50, "{seen}");
    assert!(rest.contains("the runtime damped the robot"), "{rest}");
}
