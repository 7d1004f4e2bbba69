//! The server alone: who comes in, what gets through.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::sync::atomic::Ordering;
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use crate::common::{News, Page};
use paid_live::{Command, Frame, LONGEST_COMMAND, LiveError, ServeOptions, Server, VERSION};

fn start(port: u16) -> (Server, Receiver<Command>) {
    Server::start(&ServeOptions { port: Some(port), listen: None }, r#"{"kind":"scene"}"#.to_owned())
        .expect("a free port")
}

/// The next command; one that never comes fails the test instead of holding it up.
fn received(commands: &Receiver<Command>) -> Result<Command, RecvTimeoutError> {
    commands.recv_timeout(Duration::from_secs(60))
}

fn http(address: SocketAddr, path: &str, host: &str) -> String {
    let mut stream = TcpStream::connect(address).expect("the server listens");
    write!(stream, "GET {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\n\r\n").expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer
}

fn frame(step: u32, bodies: usize) -> Vec<u8> {
    Frame { step, bodies: vec![paid_live::Body::default(); bodies], ..Frame::default() }.encode()
}

#[test]
fn the_page_is_served_to_this_machine_and_to_no_foreign_name() {
    let (server, _commands) = start(0);
    let address = server.address();
    assert!(address.ip().is_loopback());
    let page = http(address, "/", &format!("localhost:{}", address.port()));
    assert!(page.starts_with("HTTP/1.1 200") && page.contains("<canvas"), "{page:.200}");
    for header in ["default-src 'none'", "frame-ancestors 'none'", "nosniff", "no-store"] {
        assert!(page.contains(header), "{header}");
    }
    let script = http(address, "/main.js", &address.to_string());
    assert!(script.contains("content-type: text/javascript"), "{script:.300}");
    assert!(http(address, "/secret", &address.to_string()).starts_with("HTTP/1.1 404"));
    assert!(http(address, "/../Cargo.toml", &address.to_string()).starts_with("HTTP/1.1 404"));
    let rebound = http(address, "/", &format!("evil.example:{}", address.port()));
    assert!(rebound.starts_with("HTTP/1.1 403"), "{rebound:.100}");
    assert_eq!(server.counts().refused.load(Ordering::Relaxed), 1);
}

#[test]
fn a_page_of_another_origin_cannot_open_the_socket() {
    let (server, commands) = start(0);
    let address = server.address();
    for origin in ["http://evil.example", "null", "http://localhost:1"] {
        assert_eq!(Page::open(address, "", Some(origin)).err(), Some(403), "{origin}");
    }
    assert_eq!(server.counts().refused.load(Ordering::Relaxed), 3);
    let own = format!("http://{address}");
    let mut page = Page::open(address, "", Some(&own)).expect("its own page");
    page.send(Command::Pause(true));
    assert_eq!(received(&commands), Ok(Command::Pause(true)), "the first that got through");
}

#[test]
fn malformed_messages_are_dropped_and_counted_and_the_next_one_counts() {
    let (server, commands) = start(0);
    let mut page = Page::open(server.address(), "", None).expect("comes in");
    page.raw(vec![]);
    page.raw(vec![VERSION]);
    page.raw(vec![VERSION, 99]);
    page.raw(vec![VERSION, 6, 7]);
    page.raw(Command::Hold([f32::NAN, 0.0]).encode());
    page.socket.send(tungstenite::Message::Text("{}".into())).expect("sent");
    page.send(Command::Step);
    assert_eq!(received(&commands), Ok(Command::Step));
    // The empty one has no version at all; it ends nothing.
    assert_eq!(server.counts().dropped.load(Ordering::Relaxed), 6);
}

#[test]
fn a_long_message_is_dropped_and_a_huge_one_ends_its_connection_alone() {
    let (server, commands) = start(0);
    let mut hostile = Page::open(server.address(), "", None).expect("comes in");
    let mut other = Page::open(server.address(), "", None).expect("comes in");
    hostile.raw(vec![VERSION; LONGEST_COMMAND + 1]);
    hostile.send(Command::Reset);
    assert_eq!(received(&commands), Ok(Command::Reset));
    assert_eq!(server.counts().dropped.load(Ordering::Relaxed), 1);
    hostile.raw(vec![VERSION; 100_000]);
    while !matches!(hostile.next(), News::Closed(_)) {}
    other.send(Command::Step);
    assert_eq!(received(&commands), Ok(Command::Step));
}

#[test]
fn a_page_of_another_version_is_told_so() {
    let (server, _commands) = start(0);
    let mut page = Page::open(server.address(), "", None).expect("comes in");
    page.raw(vec![VERSION + 1, 7]);
    loop {
        if let News::Closed(code) = page.next() {
            assert_eq!(code, Some(4001));
            break;
        }
    }
}

#[test]
fn a_slow_viewer_gets_the_newest_frame_and_holds_up_nobody() {
    const FRAMES: u32 = 4000;
    let (server, _commands) = start(0);
    let mut slow = Page::open(server.address(), "", None).expect("comes in");
    assert!(matches!(slow.next(), News::Scene(_)));
    // 5 kB each, 20 MB in all: more than any buffer in between. The page does not read, and every call returns.
    for step in 1..=FRAMES {
        server.show(frame(step, 255));
    }
    let mut seen = Vec::new();
    while seen.last() != Some(&FRAMES) {
        if let News::Frame(frame) = slow.next() {
            seen.push(frame.step);
        }
    }
    assert!(seen.len() < FRAMES as usize && seen.is_sorted(), "{} frames", seen.len());
    let mut quick = Page::open(server.address(), "", None).expect("comes in");
    assert_eq!(quick.frame(|_| true).step, FRAMES, "the newest at once");
}

#[test]
fn several_pages_see_the_same_and_come_back_after_a_restart() {
    let (server, _commands) = start(0);
    let address = server.address();
    server.show(frame(7, 1));
    server.tell(r#"{"kind":"board","shots":3}"#.to_owned());
    let mut pages = [(); 2].map(|()| Page::open(address, "", None).expect("comes in"));
    for page in &mut pages {
        assert!(matches!(page.next(), News::Scene(_)), "the scene first");
        assert_eq!(page.board(|_| true)["shots"], 3);
        assert_eq!(page.frame(|_| true).step, 7);
    }
    assert_eq!(server.viewers(), 2);
    drop(server);
    assert!(pages.iter_mut().all(|page| matches!(page.next(), News::Closed(_))));
    let (server, _commands) = start(address.port());
    server.show(frame(1, 1));
    let mut page = Page::open(address, "", None).expect("comes in again");
    assert_eq!(page.frame(|_| true).step, 1);
}

#[test]
fn beyond_this_machine_it_takes_the_printed_token() {
    let all = "0.0.0.0:0".parse().expect("an address");
    let options = ServeOptions { port: None, listen: Some(all) };
    let (server, _commands) = Server::start(&options, "{}".to_owned()).expect("a free port");
    let url = server.url();
    let token = url.split_once("#token=").expect("a token").1;
    assert_eq!(token.len(), 32);
    let near = SocketAddr::from(([127, 0, 0, 1], server.address().port()));
    assert_eq!(Page::open(near, "", None).err(), Some(403));
    assert_eq!(Page::open(near, "?token=0", None).err(), Some(403));
    assert!(Page::open(near, &format!("?token={token}"), None).is_ok());
}

#[test]
fn a_port_that_is_taken_is_named() {
    let (server, _commands) = start(0);
    let options = ServeOptions { port: Some(server.address().port()), listen: None };
    let error = Server::start(&options, "{}".to_owned()).err().expect("taken");
    assert!(matches!(error, LiveError::Bind { .. }));
    assert!(error.to_string().starts_with(&server.address().to_string()), "{error}");
}
